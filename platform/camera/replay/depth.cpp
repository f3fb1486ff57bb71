#include "camera/replay/depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace polhode::platform {

int depth_for(unsigned level) {
  for (const int bits : {8, 10, 12, 14}) {
    if (level < 1U << static_cast<unsigned>(bits)) {
      return bits;
    }
  }
  return kFullDepth_bits;
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

std::string depth_remark(int depth_bits) {
  if (depth_bits == kFullDepth_bits) {
    return {};
  }
  return fmt::format(
      "16-bit pictures hold levels under {}: taken for {} bits (--depth-bits says other)",
      1U << static_cast<unsigned>(depth_bits),
      depth_bits);
}

bool scale_up(int depth_bits, DecodedImage* image) {
  if (depth_bits >= kFullDepth_bits || image->header.format != PixelFormat::kGray16) {
    return true;
  }
  const auto shift = static_cast<unsigned>(kFullDepth_bits - depth_bits);
  unsigned largest = 0;
  for (std::size_t i = 0; i + 1 < image->pixels.size(); i += 2) {
    std::uint16_t level = 0;
    std::memcpy(&level, &image->pixels[i], sizeof level);
    largest = std::max<unsigned>(largest, level);
    const unsigned scaled = std::min(static_cast<unsigned>(level) << shift, 0xFFFFU);
    level = static_cast<std::uint16_t>(scaled);
    std::memcpy(&image->pixels[i], &level, sizeof level);
  }
  return largest <= 0xFFFFU >> shift;
}

}  // namespace polhode::platform
