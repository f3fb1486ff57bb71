#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct TrackOptions {
  // Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", 2004, section 7.1.
  double descriptor_ratio_max = 0.8;     ///< best over second-best descriptor distance of a match at most
  // Nearly 3 times features.sigma_px. Chosen; larger keeps drifting patches.
  double forward_backward_max_px = 0.7;  ///< optical flow forth and back must end this near to its start
  // Chosen; larger follows patches farther, smaller detects features more often.
  double small_motion_max_px = 24.0;     ///< optical flow up to this predicted image motion, descriptors beyond it
};

}  // namespace polhode
