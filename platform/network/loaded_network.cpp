#include "network/loaded_network.hpp"

#include <fmt/format.h>

#include <cstring>
#include <opencv2/dnn.hpp>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "camera/replay/file_octets.hpp"
#include "errors.hpp"
#include "os/linux/memory/region.hpp"
#include "parameters/sha256.hpp"

namespace polhode::platform {
namespace {

constexpr int kSide = MaskNetwork::kSide_px;
constexpr std::size_t kPixels = std::size_t{kSide} * kSide;

std::string_view first_line(std::string_view text) { return text.substr(0, text.find('\n')); }

}  // namespace

struct LoadedNetwork::Network {
  cv::dnn::Net net;
  cv::Mat input;
  cv::Mat output;

  /// @throws cv::Exception.
  void forward(const float* gray, const float* outline) {
    auto* pixels = input.ptr<float>();
    std::memcpy(pixels, gray, kPixels * sizeof(float));
    std::memcpy(pixels + kPixels, outline, kPixels * sizeof(float));
    net.setInput(input);
    output = net.forward();
  }

  /// @throws std::runtime_error, cv::Exception.
  void read(const std::vector<std::uint8_t>& octets) {
    if (octets.empty()) {
      throw std::runtime_error("it is empty");
    }
    net = cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(octets.data()), octets.size());
    net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    const int size[] = {1, 2, kSide, kSide};
    input.create(4, size, CV_32F);
    const std::vector<float> nothing(kPixels, 0.0F);
    forward(nothing.data(), nothing.data());
    if (output.type() != CV_32F || output.dims != 4 || output.total() != kPixels ||
        output.size[2] != kSide || output.size[3] != kSide) {
      throw std::runtime_error(fmt::format("it does not give 1 x 1 x {0} x {0} numbers", kSide));
    }
  }
};

std::size_t network_octets(const std::filesystem::path& file) {
  // The file, and weights as read and as packed for the processor. One layer takes 0.7 MiB beside
  // them; a layer of 64 channels has pictures of 4 MiB, of which two are there at a time.
  constexpr std::size_t kTimesFile = 4;
  constexpr std::size_t kBeside = std::size_t{8} << 20;
  std::error_code missing;
  const auto octets = file.empty() ? 0 : std::filesystem::file_size(file, missing);
  return file.empty() || missing ? 0 : kTimesFile * static_cast<std::size_t>(octets) + kBeside;
}

LoadedNetwork::LoadedNetwork(const std::filesystem::path& file) {
  if (file.empty()) {
    return;
  }
  std::vector<std::uint8_t> octets;
  read_file_at_start(file, "network.file: " + file.string(), octets);
  const PoolScope scope(Pool::kGeneral);
  auto network = std::make_unique<Network>();
  try {
    network->read(octets);
  } catch (const std::exception& problem) {
    throw UnusableInput(fmt::format("network.file: {}: not a network for outlines: {}",
                                    file.string(),
                                    first_line(problem.what())));
  }
  network_ = std::move(network);
  sha256_ = sha256_of({reinterpret_cast<const char*>(octets.data()), octets.size()});
}

LoadedNetwork::~LoadedNetwork() = default;

MaskNetwork LoadedNetwork::hook() {
  return present() ? MaskNetwork{.ask = ask, .context = this} : MaskNetwork{};
}

bool LoadedNetwork::ask(void* self, const float* gray, const float* outline, float* target) {
  auto* known = static_cast<LoadedNetwork*>(self);
  ++known->times_asked_;
  try {
    known->network_->forward(gray, outline);
  } catch (const std::exception&) {
    return false;
  }
  std::memcpy(target, known->network_->output.ptr<float>(), kPixels * sizeof(float));
  return true;
}

}  // namespace polhode::platform
