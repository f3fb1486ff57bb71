// The packets of a run in one file, end to end, in order of publication, with the SHA-256 of the
// whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "output_file.hpp"
#include "parameters/sha256.hpp"

namespace polhode::platform {

class PacketFile {
 public:
  explicit PacketFile(const std::filesystem::path& file) : out_(file) {}

  void append(std::span<const std::uint8_t> packets);

  [[nodiscard]] std::uint64_t octets() const { return octets_; }

  /// Closes the file. @return the SHA-256 of all that was appended.
  std::string finish();

 private:
  OutputFile out_;
  Sha256 hash_;
  std::uint64_t octets_ = 0;
};

}  // namespace polhode::platform
