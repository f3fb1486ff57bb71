#pragma once

namespace polhode {

struct MotionOptions {
  int window_poses_max = 64;      ///< poses that a rate is fitted to at most, 4 .. limits::kMotionPoses
  double window_angle_max_rad = 1.05;  ///< body rotation over the window at most (60 deg), 0.1 .. 3
};

}  // namespace polhode
