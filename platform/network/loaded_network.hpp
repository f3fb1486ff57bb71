// A network for the target's outline, from a file, by way of OpenCV's dnn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "mask/network.hpp"

namespace polhode::platform {

/// Octets that reading and asking a network of this file takes from the general pool; 0 without a
/// file.
std::size_t network_octets(const std::filesystem::path& file);

/// Takes 1 x 2 x 128 x 128 numbers (levels, outline), gives 1 x 1 x 128 x 128 (probability of
/// target).
class LoadedNetwork {
 public:
  /// Reads the file and asks the network once, so that its memory is there before the first frame.
  /// @param file ONNX; empty: there is no network.
  /// @throws UnusableInput: the file is missing, no network, or takes and gives something else.
  explicit LoadedNetwork(const std::filesystem::path& file);
  ~LoadedNetwork();
  LoadedNetwork(const LoadedNetwork&) = delete;
  LoadedNetwork& operator=(const LoadedNetwork&) = delete;

  /// For Component::set_mask_network; this object has to outlive its use.
  [[nodiscard]] MaskNetwork hook();
  [[nodiscard]] bool present() const { return network_ != nullptr; }
  [[nodiscard]] const std::string& sha256() const { return sha256_; }
  [[nodiscard]] std::uint64_t times_asked() const { return times_asked_; }

 private:
  struct Network;
  static bool ask(void* self, const float* gray, const float* outline, float* target);

  std::unique_ptr<Network> network_;
  std::string sha256_;
  std::uint64_t times_asked_ = 0;
};

}  // namespace polhode::platform
