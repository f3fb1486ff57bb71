#include "initialisation/initialise.hpp"

#include <algorithm>
#include <cmath>

#include "initialisation/at_rest.hpp"
#include "initialisation/core.hpp"
#include "initialisation/selection.hpp"

namespace polhode {
namespace {

// In RMS extents (decision 0031). Depths spread by some 0.6 extents, so 2 sigma are a fifth
// of that. With 0.12 one map of 40 began with a quarter too much turn, and stayed bent.
constexpr double kDepthSigmaMax = 0.06;
// Wrong matches take 5 to 25 % of the observations with them. The cost margin, not this, refuses
// wrong hypotheses that explain half of the observations.
constexpr double kInlierRatioMin = 0.5;

/// Most bodies are convex: the cue is evidence for one that is, and as much against one that is
/// hollow. What it may add is bounded by what is known of bodies (decision 0107).
double margin_needed(double convexity, const StartOptions& options) {
  if (convexity >= kConvexityMin) {
    return options.chi2_gap_convexity;
  }
  const bool is_hollow = convexity <= -kConvexityMin;
  return options.chi2_gap_commit +
         (is_hollow ? options.chi2_gap_commit - options.chi2_gap_convexity : 0.0);
}

StartDecision decide(const StartOutcome& out, const StartOptions& options, double noise_scale) {
  if (out.inlier_ratio < kInlierRatioMin || noise_scale > kNoiseScaleMax) {
    return StartDecision::kNoHypothesis;
  }
  if (!(out.selection_depth_sigma < kDepthSigmaMax)) {
    return StartDecision::kTooLittleMotion;
  }
  return out.chi2_gap >= margin_needed(out.convexity, options) ? StartDecision::kCommit
                                                               : StartDecision::kMarginTooSmall;
}

}  // namespace

StartOutcome select_hypothesis(const StartProblem& problem,
                               const StartOptions& options,
                               StartWorkspace* workspace) {
  StartOutcome out;
  if (!choose_selection_set(problem, &workspace->set)) {
    return out;
  }
  out.crowded = is_crowded(problem, workspace->set);
  Selection selection{.problem = problem, .options = options};
  select_hypotheses(&selection, workspace);
  if (workspace->refined.empty()) {
    out.decision = StartDecision::kNoHypothesis;
    return out;
  }
  StartHypothesis& winner = workspace->refined[0];
  const double noise = selection.sigma_scale * winner.fit.noise_scale;
  out.winner = winner.kind;
  out.winner_reversed = winner.reversed;
  out.hypotheses = static_cast<int>(workspace->refined.size());
  out.reduced_chi2 = noise * noise;
  out.inlier_ratio = static_cast<double>(winner.fit.agreeing) / std::max(1, winner.fit.telling);
  out.chi2_gap = cost_margin_of(selection, workspace);
  const double for_rest = compare_at_rest(&selection, workspace);
  if (for_rest >= 0.0) {
    out.chi2_gap = for_rest;
  }
  out.convexity = convexity_of(workspace->set, &winner);
  adjust_all_tracks(selection, workspace, &out);
  out.decision = decide(out, options, noise);
  return out;
}

}  // namespace polhode
