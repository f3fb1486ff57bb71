#include "camera/replay/depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "camera/replay/file_octets.hpp"

namespace polhode::platform {
namespace {

constexpr int kFull_bits = 16;

/// Smallest depth of a camera that has this level.
int depth_for(unsigned level) {
  for (const int bits : {10, 12, 14}) {
    if (level < 1U << static_cast<unsigned>(bits)) {
      return bits;
    }
  }
  return kFull_bits;
}

unsigned largest_level(const DecodedImage& image) {
  unsigned largest = 0;
  for (std::size_t i = 0; i + 1 < image.pixels.size(); i += 2) {
    std::uint16_t level = 0;
    std::memcpy(&level, &image.pixels[i], sizeof level);
    largest = std::max<unsigned>(largest, level);
  }
  return largest;
}

}  // namespace

int depth_of(const Sequence& sequence) {
  constexpr std::size_t kLookedAt = 5;  // evenly over the sequence: the first ones may be dark
  const std::size_t step = std::max<std::size_t>(1, sequence.frames.size() / kLookedAt);
  std::vector<std::uint8_t> octets;
  DecodedImage image;
  unsigned largest = 0;
  int said = 0;
  for (std::size_t i = 0; i < sequence.frames.size(); i += step) {
    ImageHeader header;
    if (read_file(sequence.image_folder / sequence.frames[i].file,
                  octets,
                  frame_octets_max(sequence.camera)) ||
        read_header(octets, header) || header.width_px != sequence.camera.width_px ||
        header.height_px != sequence.camera.height_px) {
      continue;
    }
    if (header.format != PixelFormat::kGray16 || header.significant_bits == kFull_bits) {
      return kFull_bits;
    }
    if (!decode(octets, image)) {
      largest = std::max(largest, largest_level(image));
      said = std::max(said, header.significant_bits);
    }
  }
  if (largest == 0) {
    return kFull_bits;  // black, or none could be read
  }
  said = std::min(said, kFull_bits);  // of a damaged file, it may be any octet
  const int found = depth_for(largest);
  return said == 0 || found == kFull_bits ? found : std::max(found, said);
}

std::string depth_remark(int depth_bits) {
  if (depth_bits == kFull_bits) {
    return {};
  }
  return fmt::format(
      "16-bit pictures hold levels under {}: taken for {} bits (--depth-bits says other)",
      1U << static_cast<unsigned>(depth_bits),
      depth_bits);
}

void scale_up(int depth_bits, DecodedImage* image) {
  if (depth_bits >= kFull_bits || image->header.format != PixelFormat::kGray16) {
    return;
  }
  const auto shift = static_cast<unsigned>(kFull_bits - depth_bits);
  for (std::size_t i = 0; i + 1 < image->pixels.size(); i += 2) {
    std::uint16_t level = 0;
    std::memcpy(&level, &image->pixels[i], sizeof level);
    const unsigned scaled = std::min(static_cast<unsigned>(level) << shift, 0xFFFFU);
    level = static_cast<std::uint16_t>(scaled);
    std::memcpy(&image->pixels[i], &level, sizeof level);
  }
}

}  // namespace polhode::platform
