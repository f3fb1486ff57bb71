// Cameras of 10, 12 and 14 bits, whose levels stand in 16-bit pictures as they came.
#pragma once

#include <string>

#include "camera/replay/decode.hpp"
#include "camera/replay/sequence.hpp"

namespace polhode::platform {

/// Bits of the largest level in 16-bit pictures: 10, 12, 14 or 16. By a few pictures of the
/// sequence: where they say their bits, levels are of so many only if none is larger, as PNG asks
/// writers to shift them up. 16 for other pictures.
int depth_of(const Sequence& sequence);

/// For people: what the levels were taken for; empty where nothing is changed.
std::string depth_remark(int depth_bits);

/// Shifts the levels up, so that the largest one is nearly full scale. Nothing for 8-bit pictures.
void scale_up(int depth_bits, DecodedImage* image);

}  // namespace polhode::platform
