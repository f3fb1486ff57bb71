#include "initialisation/initialise.hpp"

#include <algorithm>
#include <cmath>

#include "initialisation/core.hpp"
#include "initialisation/selection.hpp"

namespace polhode {
namespace {

// Depths of a body spread by some 0.6 extents: a fifth of that is then 2 sigma off. The
// adjustments that follow the commit bring it down.
constexpr double kDepthSigmaMax = 0.06;
// Tracks go wrong in 5 to 20 % of cases, and take their sightings with them; on a body of a hundred
// pixels that turns by 6 deg a frame in twice as many. A wrong hypothesis that explains half of the
// sightings is told by the gap, not by this.
constexpr double kInlierRatioMin = 0.5;

StartDecision decide(const StartOutcome& out, const StartOptions& options, double noise_scale) {
  if (out.inlier_ratio < kInlierRatioMin || noise_scale > kNoiseScaleMax) {
    return StartDecision::kNoHypothesis;
  }
  if (!(out.contest_depth_sigma < kDepthSigmaMax)) {
    return StartDecision::kTooLittleMotion;
  }
  const bool clear = out.chi2_gap >= options.chi2_gap_commit;
  const bool likely = out.chi2_gap >= options.chi2_gap_convexity && out.convexity >= kConvexityMin;
  return clear || likely ? StartDecision::kCommit : StartDecision::kTwinsTooClose;
}

}  // namespace

StartOutcome run_start_contest(const StartProblem& problem,
                               const StartOptions& options,
                               StartWorkspace& workspace) {
  StartOutcome out;
  if (!select_contest_set(problem, &workspace.set)) {
    return out;
  }
  out.crowded = is_crowded(problem, workspace.set);
  Contest contest{.problem = problem, .options = options, .w = workspace};
  hold_contest(&contest);
  if (workspace.refined.empty()) {
    out.decision = StartDecision::kNoHypothesis;
    return out;
  }
  StartHypothesis& winner = workspace.refined[0];
  const double noise = contest.sigma_scale * winner.fit.noise_scale;
  out.winner = winner.kind;
  out.winner_reversed = winner.reversed;
  out.hypotheses = static_cast<int>(workspace.refined.size());
  out.reduced_chi2 = noise * noise;
  out.inlier_ratio = static_cast<double>(winner.fit.inliers) / winner.fit.sightings;
  out.chi2_gap = chi2_gap(contest);
  out.convexity = convexity_of(contest, &winner);
  adjust_all_tracks(contest, &out);
  out.decision = decide(out, options, noise);
  return out;
}

}  // namespace polhode
