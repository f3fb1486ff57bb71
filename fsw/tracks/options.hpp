#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct TrackOptions {
  double descriptor_ratio_max = 0.8;     ///< best over second-best descriptor distance, 0.3 .. 1
  double forward_backward_max_px = 0.7;  ///< optical flow must come back this near to its start, 0.05 .. 5
  double small_motion_max_px = 24.0;     ///< up to this predicted image motion optical flow follows, beyond it descriptors, 1 .. 100
};

}  // namespace polhode
