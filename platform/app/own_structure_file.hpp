// Reads the servicer's own structure in the image, from an image that the operator has drawn.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "mask/own_structure.hpp"
#include "pipeline/parameters.hpp"

namespace polhode::platform {

class OwnStructureFile {
 public:
  /// Reads the image: white is the servicer's own, black is not; half of full scale divides them.
  /// @param file PNG or PGM of the camera's size; empty: nothing is the servicer's.
  /// @throws UnusableInput naming the file and what is allowed: it is missing, no such image, of
  /// another size, or it is all black, all white or of many grays.
  OwnStructureFile(const std::filesystem::path& file, const CameraParameters& camera);

  /// For set_own_structure(); null without a file. This object has to outlive its use.
  [[nodiscard]] const OwnStructure* hook() const { return present() ? &own_ : nullptr; }
  [[nodiscard]] bool present() const { return !own_.pixels.empty(); }
  [[nodiscard]] const std::string& sha256() const { return sha256_; }  ///< of the file
  [[nodiscard]] double part() const { return part_; }  ///< of the image that it covers

 private:
  OwnStructure own_;
  std::string sha256_;
  double part_ = 0.0;
};

/// Bytes that reading and keeping it takes from the general pool; 0 without a file.
std::size_t own_structure_bytes(const std::filesystem::path& file, const CameraParameters& camera);

}  // namespace polhode::platform
