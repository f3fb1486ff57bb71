// From which frame on the images could decide on the depth sign: what "late" is measured against.
#pragma once

#include <memory>
#include <span>

#include "geometry/pose.hpp"
#include "initialisation/outcome.hpp"

namespace polhode::benchmark {

/// What the tracks of one selection tell, judged by the true motion.
struct Decidability {
  bool known = false;     ///< enough tracks agree with the true motion
  double margin = 0.0;    ///< expected cost margin (chi-square) of the truth to the best
                          ///< depth-reversed solution, over the fitted noise
  double noise = 0.0;     ///< of the true geometry's residuals, over the sigma that features claim
  double agreeing = 0.0;  ///< share of the tracks that agree with the true motion
  int tracks = 0;         ///< that agree
};

/// The selection's tracks are placed by the true poses, and their images made anew there without
/// noise. Then the truth costs nothing, and what the depth-reversed solution costs, adjusted to the
/// end, is the margin that the noise scatters about.
/// @param true_poses  by frame of the problem; any unit of length.
Decidability decide_by_truth(const InitialProblem& problem,
                             std::span<const Pose> true_poses,
                             InitialWorkspace* workspace);

}  // namespace polhode::benchmark
