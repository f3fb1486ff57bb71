// An image of floats; its memory is not owned.
#pragma once

#include <cstddef>

namespace polhode::sift {

/// Rows are `stride` floats apart: a multiple of kRowGrain, at least the width. Loops over a row
/// may run on to the next multiple; the values there are padding.
struct Plane {
  float* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  [[nodiscard]] float* row(int y) const { return data + static_cast<std::ptrdiff_t>(y) * stride; }
};

/// Floats in the widest register used (AVX2).
inline constexpr int kRowGrain = 8;
constexpr int stride_of(int width) { return (width + kRowGrain - 1) / kRowGrain * kRowGrain; }

}  // namespace polhode::sift
