#include "app/own_structure_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "camera/replay/decode.hpp"
#include "camera/replay/file_bytes.hpp"
#include "errors.hpp"
#include "os/linux/memory/region.hpp"
#include "parameters/sha256.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAllowed = "allowed is a PNG or PGM, white where the servicer is seen";

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw UnusableInput(fmt::format("mask.file: {}: {}", file.string(), why));
}

std::size_t pixels_of(const CameraParameters& camera) {
  return static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
}

bool is_jpeg(const std::vector<std::uint8_t>& bytes) {
  return bytes.size() >= 2 && bytes[0] == 0xFF && bytes[1] == 0xD8;
}

/// The image's levels, 8 bits a pixel. Its size is looked at before memory is taken for it.
std::vector<std::uint8_t> read_levels(const fs::path& file,
                                      const CameraParameters& camera,
                                      const std::vector<std::uint8_t>& bytes) {
  if (is_jpeg(bytes)) {
    refuse(file, fmt::format("is a JPEG, whose edges are not sharp; {}", kAllowed));
  }
  DecodedImage image;
  if (const Refusal problem = read_header(bytes, image.header)) {
    refuse(file, fmt::format("{}; {}", *problem, kAllowed));
  }
  if (image.header.width_px != camera.width_px || image.header.height_px != camera.height_px) {
    refuse(file,
           fmt::format("is {} x {}, allowed is the camera's {} x {}",
                       image.header.width_px,
                       image.header.height_px,
                       camera.width_px,
                       camera.height_px));
  }
  if (const Refusal problem = decode(bytes, image)) {
    refuse(file, fmt::format("{}; {}", *problem, kAllowed));
  }
  if (image.header.format == PixelFormat::kGray8) {
    return std::move(image.pixels);
  }
  std::vector<std::uint8_t> levels(pixels_of(camera));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    std::uint16_t level = 0;
    std::memcpy(&level, image.pixels.data() + 2 * i, sizeof level);
    levels[i] = static_cast<std::uint8_t>(level >> 8U);
  }
  return levels;
}

/// A photograph in place of a drawing is mostly between a quarter and three quarters of full scale;
/// smoothed edges of a drawing are a few per cent of it.
void refuse_gray(const fs::path& file, const std::vector<std::uint8_t>& levels) {
  constexpr int kGrayMin = 64;
  constexpr int kGrayMax = 191;
  constexpr std::size_t kPercentMax = 10;
  const auto gray =
      static_cast<std::size_t>(std::count_if(levels.begin(), levels.end(), [](std::uint8_t level) {
        return level >= kGrayMin && level <= kGrayMax;
      }));
  if (100 * gray > kPercentMax * levels.size()) {
    refuse(file,
           fmt::format("{} % of its pixels are neither black nor white, allowed are {} %",
                       100 * gray / levels.size(),
                       kPercentMax));
  }
}

}  // namespace

OwnStructureFile::OwnStructureFile(const fs::path& file, const CameraParameters& camera) {
  if (file.empty()) {
    return;
  }
  std::vector<std::uint8_t> bytes;
  if (const auto unreadable = read_file(file, bytes)) {
    refuse(file, *unreadable);
  }
  std::vector<std::uint8_t> levels = read_levels(file, camera, bytes);
  refuse_gray(file, levels);
  constexpr double kHalf = 127.0;
  const PoolScope scope(Pool::kGeneral);
  cv::Mat pixels;
  cv::threshold(cv::Mat(camera.height_px, camera.width_px, CV_8UC1, levels.data()),
                pixels,
                kHalf,
                255.0,
                cv::THRESH_BINARY);
  const auto own = static_cast<std::size_t>(cv::countNonZero(pixels));
  if (own == 0) {
    refuse(file, "is black all over, so nothing is the servicer's; leave mask.file empty for that");
  }
  if (own == levels.size()) {
    refuse(file, "is white all over, so nothing could be target; black is what may be");
  }
  part_ = static_cast<double>(own) / static_cast<double>(levels.size());
  sha256_ = sha256_of({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  own_ = own_structure(pixels);
}

std::size_t own_structure_bytes(const fs::path& file, const CameraParameters& camera) {
  // The file is no longer than an image of 16 bits and its headers; then the image, its levels, and
  // the two reduced ones. The PNG library's share is in add_sequence().
  constexpr std::size_t kPerPixel = 8;
  constexpr std::size_t kBeside = std::size_t{512} << 10U;
  return file.empty() ? 0 : kPerPixel * pixels_of(camera) + kBeside;
}

}  // namespace polhode::platform
