#include "initialisation/initialise.hpp"

#include <algorithm>
#include <cmath>

#include "initialisation/at_rest.hpp"
#include "initialisation/core.hpp"
#include "initialisation/selection.hpp"

namespace polhode {
namespace {

// In RMS extents (decision 0031). Depths spread by some 0.6 extents, so 2 sigma are a fifth of
// that. With 0.12 one map of 40 began with a rotation a quarter too large, and stayed bent.
constexpr double kDepthSigmaMax = 0.06;
// Least share of inliers. Wrong matches take 5 to 25 % of the observations with them. Wrong
// hypotheses that explain half of the observations are refused by the cost margin.
constexpr double kInlierRatioMin = 0.5;

/// Cost margin that a commitment needs. Most bodies are convex, so the cue supports a convex
/// hypothesis and counts as much against a hollow one. Its weight is bounded (decision 0107).
double margin_min(double convexity, const InitialOptions& options) {
  if (convexity >= kConvexityMin) {
    return options.chi2_gap_convexity;
  }
  const bool is_hollow = convexity <= -kConvexityMin;
  return options.chi2_gap_commit +
         (is_hollow ? options.chi2_gap_commit - options.chi2_gap_convexity : 0.0);
}

InitialDecision decide(const InitialOutcome& out, const InitialOptions& options, double noise) {
  if (out.inlier_ratio < kInlierRatioMin || noise > kNoiseScaleMax) {
    return InitialDecision::kNoHypothesis;
  }
  if (!(out.selection_depth_sigma < kDepthSigmaMax)) {
    return InitialDecision::kTooLittleMotion;
  }
  return out.chi2_margin >= margin_min(out.convexity, options) ? InitialDecision::kCommit
                                                               : InitialDecision::kMarginTooSmall;
}

}  // namespace

InitialOutcome select_hypothesis(const InitialProblem& problem,
                                 const InitialOptions& options,
                                 InitialWorkspace* workspace) {
  InitialOutcome out;
  if (!choose_selection_set(problem, &workspace->set)) {
    return out;
  }
  out.crowded = is_crowded(problem, workspace->set);
  Selection selection{.problem = problem, .options = options};
  select_hypotheses(&selection, workspace);
  if (workspace->refined.empty()) {
    out.decision = InitialDecision::kNoHypothesis;
    return out;
  }
  InitialHypothesis& winner = workspace->refined[0];
  const double noise = selection.sigma_scale * winner.fit.noise_scale;
  out.winner = winner.kind;
  out.winner_reversed = winner.reversed;
  out.hypotheses = static_cast<int>(workspace->refined.size());
  out.reduced_chi2 = noise * noise;
  out.inlier_ratio = static_cast<double>(winner.fit.agreeing) / std::max(1, winner.fit.redundant);
  out.chi2_margin = cost_margin_of(selection, workspace);
  const double for_rest = compare_at_rest(&selection, workspace);
  if (for_rest >= 0.0) {
    out.chi2_margin = for_rest;
  }
  out.convexity = convexity_of(workspace->set, &winner);
  adjust_all_tracks(selection, workspace, &out);
  out.decision = decide(out, options, noise);
  return out;
}

}  // namespace polhode
