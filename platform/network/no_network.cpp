// A build without networks for outlines (CMake option POLHODE_NETWORK): OpenCV's dnn is not linked.
#include "errors.hpp"
#include "network/loaded_network.hpp"

namespace polhode::platform {

struct LoadedNetwork::Network {};

std::size_t network_octets(const std::filesystem::path& /*file*/) { return 0; }

LoadedNetwork::LoadedNetwork(const std::filesystem::path& file) {
  if (!file.empty()) {
    throw UnusableInput("network.file = \"" + file.string() +
                        "\": this build has no networks; allowed is none (CMake option "
                        "POLHODE_NETWORK=ON builds them in)");
  }
}

LoadedNetwork::~LoadedNetwork() = default;

MaskNetwork LoadedNetwork::hook() { return {}; }

}  // namespace polhode::platform
