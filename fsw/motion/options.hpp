#pragma once

namespace polhode {

struct MotionOptions {
  int window_poses_max = 64;      ///< poses that a rate is fitted to at most, 4 .. limits::kMotionPoses
  /// Body rotation over the window at most, 0.1 .. 3. At 1.75 (100 deg) the polynomial's first missing term is 1 % of the
  /// motion's bend; the rate's sigma falls as the window to the power 1.5.
  double window_angle_max_rad = 1.75;
};

}  // namespace polhode
