// The rounds of hypothesis selection.
#pragma once

#include "initialisation/options.hpp"
#include "initialisation/outcome.hpp"

namespace polhode {

/// Input, options and workspace that all rounds share. What they work on is InitialWorkspace's.
struct Selection {
  const InitialProblem& problem;
  const InitialOptions& options;
  bool rotations_fixed = false;  ///< attitudes are those of a body at rest
  double sigma_scale = 1.0;  ///< noise over the caller's sigma by the best hypothesis so far, >= 1
};

// The caller's sigma may be too small by this factor at most. Chosen; with more noise than that no
// hypothesis is accepted.
inline constexpr double kNoiseScaleMax = 2.0;
// Two standard deviations: the sign of the curvature is right in 98 % of cases.
inline constexpr double kConvexityMin = 2.0;
// Width of the loss by which hypotheses are compared, in sigmas: exp(-4^2 / 2) = 3e-4 of good
// residuals, with two coordinates, lie beyond.
inline constexpr double kTruncation_sigmas = 4.0;

/// Loss by which hypotheses are compared.
InitialAdjustmentOptions selection_loss(const Selection& selection, int iterations_max);

/// Seeds, families, depth-reversed solutions, extension to all frames, and the winner's own
/// depth-reversed solution. Leaves hypotheses of different geometry in workspace.refined, the
/// winner first; none when all failed.
void select_hypotheses(Selection* selection, InitialWorkspace* workspace);

/// Adjusts a hypothesis that may be far from its minimum, to convergence as the comparison needs
/// it.
/// @return false where there is no minimum.
bool refine_to_minimum(const Selection& selection,
                       std::span<const TrackObservation> observations,
                       InitialAdjustmentWorkspace* workspace,
                       InitialHypothesis* hypothesis);

/// Cost margin of the winner to the best rival of different geometry, in chi-square of the true
/// noise.
double cost_margin_of(const Selection& selection, InitialWorkspace* workspace);

/// Convexity cue in the middle of the core.
double convexity_of(const SelectionSet& set, InitialHypothesis* hypothesis);

/// Extends the winner to all tracks: joint adjustment, wrong tracks dropped, covariances. Fills
/// poses, points and both depth sigmas.
void adjust_all_tracks(const Selection& selection,
                       InitialWorkspace* workspace,
                       InitialOutcome* out);

}  // namespace polhode
