// A raw frame as the camera hands it over: plain memory, not owned.
#pragma once

#include <cstddef>
#include <cstdint>

namespace polhode {

enum class PixelFormat { kGray8, kGray16 };

struct ImageView {
  const std::uint8_t* data =
      nullptr;  ///< first byte of the top row; 16-bit pixels in the machine's order
  int width_px = 0;
  int height_px = 0;
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::kGray8;
};

}  // namespace polhode
