// A picture of floats in memory that belongs to someone else.
#pragma once

#include <cstddef>

namespace polhode::sift {

/// Rows are `stride` floats apart, a multiple of 8 that is not under the width: loops over a row
/// may run on to the next multiple of 8; what they leave there means nothing.
struct Plane {
  float* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  [[nodiscard]] float* row(int y) const { return data + static_cast<std::ptrdiff_t>(y) * stride; }
};

inline constexpr int kRowGrain = 8;
constexpr int stride_of(int width) { return (width + kRowGrain - 1) / kRowGrain * kRowGrain; }

}  // namespace polhode::sift
