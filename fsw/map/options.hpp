#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct LocaliseOptions {
  int inliers_min = 12;            ///< fewer leave the frame without a pose, 6 .. 200
  int ransac_iterations_max = 200; ///< 10 .. 5000
  double search_floor_px = 4.0;    ///< guided search never looks nearer than this, 1 .. 50
};

struct MapOptions {
  int keyframes_max = 100;                   ///< 8 .. limits::kKeyframes
  double keyframe_rotation_min_rad = 0.05;   ///< 2.9 deg of body rotation make a new keyframe, twice that when half of the table is taken, 0.02 .. 0.5
  double keyframe_tracked_min = 0.6;         ///< a keyframe comes sooner when less than this part is still tracked, 0.1 .. 0.95
  int window_keyframes = 10;                 ///< keyframes that the windowed adjustment moves, 3 .. 30
  int adjustment_iterations_max = 10;        ///< 1 .. 100
  double landmark_parallax_min_rad = 0.035;  ///< 2 deg: a 0.5 px error at f = 1000 px is then 1.4 % of depth, 0.005 .. 0.5
};

}  // namespace polhode
