// Gradients on a small rotated and scaled grid over a level of the scale space.
#pragma once

#include <array>

#include "features/plane.hpp"

namespace polhode::sift {

/// The grid's middle, and the step to its next column. The step to the next row is that rotated by
/// 90 deg.
struct PatchFrame {
  float x = 0.0F;
  float y = 0.0F;
  float step_x = 1.0F;
  float step_y = 0.0F;
};

/// kSide x kSide gradients, row by row. Lengths are in gray levels per two steps of the grid.
/// Directions are in 0 .. 2 pi: 0 towards the next column, pi / 2 towards the next row.
template <int kSide>
struct Gradients {
  static constexpr int kCount = kSide * kSide;
  std::array<float, kCount> length{};
  std::array<float, kCount> angle_rad{};
};

/// Beyond the image's border the outermost pixels are repeated.
template <int kSide>
void sample_gradients(const Plane& level, const PatchFrame& frame, Gradients<kSide>* out);

// Instances for orientations and descriptors.
extern template void sample_gradients<12>(const Plane&, const PatchFrame&, Gradients<12>*);
extern template void sample_gradients<16>(const Plane&, const PatchFrame&, Gradients<16>*);

}  // namespace polhode::sift
