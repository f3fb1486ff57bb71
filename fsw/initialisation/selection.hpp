// The rounds of a contest between hypotheses.
#pragma once

#include "initialisation/options.hpp"
#include "initialisation/outcome.hpp"

namespace polhode {

/// What the rounds share.
struct Contest {
  const StartProblem& problem;
  const StartOptions& options;
  StartWorkspace& w;
  double sigma_scale =
      1.0;  ///< the noise over the caller's sigma, as the best hypothesis so far has it; 1 or more
};

// The caller's sigma may be wrong by this factor before the fit itself is in doubt.
inline constexpr double kNoiseScaleMax = 4.0;
// Two standard deviations: the sign of the curvature is right in 98 % of cases.
inline constexpr double kConvexityMin = 2.0;

/// Loss with which hypotheses are compared.
StartAdjustmentOptions contest_loss(const Contest& contest, int iterations_max);

/// Seeds, families, twins, growth to all frames, and the winner's own twin: leaves
/// workspace.refined with hypotheses of different geometry, the winner first; empty when none
/// survived.
void hold_contest(Contest* contest);

/// By how much the best rival of different geometry fits worse than the winner, in chi-square of
/// the true noise.
double chi2_gap(const Contest& contest);

/// Convexity cue in the middle of the core.
double convexity_of(const Contest& contest, StartHypothesis* hypothesis);

/// Winner to all tracks: joint adjustment, wrong tracks dropped, covariances; fills poses, points
/// and both depth sigmas.
void adjust_all_tracks(const Contest& contest, StartOutcome* out);

}  // namespace polhode
