// Cameras of 8, 10, 12 and 14 bits, whose levels stand in 16-bit images as they came.
#pragma once

#include <string>

#include "camera/replay/decode.hpp"

namespace polhode::platform {

constexpr int kFullDepth_bits = 16;  ///< of the levels in a 16-bit image

/// Smallest depth of a camera that has this level: 8, 10, 12, 14 or 16 bits.
int depth_for(unsigned level);

/// Of a 16-bit image.
unsigned largest_level(const DecodedImage& image);

/// A remark on the assumed depth of the levels; empty where nothing is changed.
std::string depth_remark(int depth_bits);

/// Shifts the levels up, so that the largest one is nearly full scale. Nothing for 8-bit images.
/// @return false: some were larger than such a camera's, and were cut
bool scale_up(int depth_bits, DecodedImage* image);

}  // namespace polhode::platform
