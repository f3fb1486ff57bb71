#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct LocaliseOptions {
  // 24 equations for 6 unknowns. Chosen; smaller lets chance matches carry a pose.
  int inliers_min = 12;            ///< a frame with fewer inliers has no pose
  // Three inliers come together with 99.9 % where 33 % are inliers: ln(0.001) / ln(1 - 0.33^3) is 189.
  int ransac_iterations_max = 200; ///< pose hypotheses of one RANSAC at most
  // 16 times features.sigma_px. Chosen; larger admits more chance matches.
  double search_floor_px = 4.0;    ///< least radius of the guided search
};

struct MapOptions {
  // All that the table holds.
  int keyframes_max = 100;                   ///< keyframes held at most
  // decision 0038: 0.035 gained nothing.
  double keyframe_rotation_min_rad = 0.05;   ///< body rotation (2.9 deg) to a new keyframe; doubled when half of keyframes_max are held
  // Chosen; larger makes more keyframes.
  double keyframe_tracked_min = 0.6;         ///< a keyframe comes sooner when a smaller fraction of the last one's landmarks is tracked
  // 29 deg of rotation at the closest spacing. Chosen; larger: longer jobs.
  int window_keyframes = 10;                 ///< keyframes that the windowed adjustment moves
  // Chosen; larger: closer to the minimum, and longer jobs.
  int adjustment_iterations_max = 10;        ///< iterations of one adjustment at most
  // decision 0064: more gains nothing, and takes some 700 bytes of the jobs' pool each.
  int adjustment_observations_max = 10000;   ///< observations of one adjustment; the best-seen landmarks take part, the others follow
  // 2 deg: a 0.5 px error at f = 1000 px is then 1.4 % of depth.
  double landmark_parallax_min_rad = 0.035;  ///< least angle between the rays of a new landmark
};

}  // namespace polhode
