#include "initialisation/selection.hpp"

#include <algorithm>
#include <cmath>

#include "initialisation/convexity.hpp"
#include "initialisation/extend.hpp"
#include "initialisation/hypotheses.hpp"

namespace polhode {
namespace {

// Relative differences up to which two geometries are one, and from which they are different. Both
// lie under the quarter that counts as right in tests/synthetic/initial_problem.hpp. Chosen; larger
// merges a rival with the winner, smaller makes a rival of the winner's own solution.
constexpr double kSameGeometry = 0.15;
constexpr double kDifferentGeometry = 0.20;
// Seeds that are fully refined, each with its depth-reversed solution. Chosen; more cost time.
constexpr std::size_t kFamilies = 6;
// Frames posed on either side between two adjustments. Chosen; with more, errors add up.
constexpr int kExtendRounds = 3;
// Times that the winner may be replaced by its depth-reversed solution. Chosen; normally one
// decides.
constexpr int kReversalRounds = 3;
// Depth and rotation compensate for each other along a valley in which steps are short. A
// hypothesis in the winner's valley must converge, else it counts as a rival (decision 0029). Most
// settle in a tenth of this.
constexpr int kSettleIterations = 60;
// Bound on a track's share of a cost margin: a wrong track that one hypothesis happens to explain
// would decide alone. Chosen.
constexpr double kTrackMarginMax = 4.0;
// A cost margin of 25 scatters by 10. Agreement of the tracks under 1.5 sigma is no evidence.
constexpr double kAgreementMin = 1.5;
// Width of the Cauchy loss at the noise, and its limit while residuals are large, in sigmas.
// Chosen; a larger limit lets the worst observations of a seed that is far off rule the fit.
constexpr double kNarrow_sigmas = 3.0;
constexpr double kWideMax_sigmas = 300.0;

/// Iterations of a refinement: by a wide loss, by a narrow one, and by the loss of the comparison.
struct Iterations {
  int wide;
  int narrow;
  int last;
};
// Chosen for the time: seeds need only find their family, families their minimum. Extension follows
// short steps; the comparison needs convergence.
constexpr Iterations kSeedIterations{.wide = 6, .narrow = 4, .last = 0};
constexpr Iterations kFamilyIterations{.wide = 8, .narrow = 10, .last = 15};
constexpr Iterations kExtendIterations{.wide = 3, .narrow = 3, .last = 0};
constexpr Iterations kExtendedIterations{.wide = 5, .narrow = 10, .last = kSettleIterations};
constexpr Iterations kReversedIterations{.wide = 8, .narrow = 12, .last = kSettleIterations};

void sort_by_cost(InitialHypotheses* list) {
  std::stable_sort(
      list->begin(), list->end(), [](const InitialHypothesis& a, const InitialHypothesis& b) {
        return a.fit.cost < b.fit.cost;
      });
}

/// Cauchy loss as wide as the residuals are now, then as wide as the noise, then the loss of the
/// comparison.
bool refine(const Selection& c,
            std::span<const TrackObservation> observations,
            const Iterations& iterations,
            InitialAdjustmentWorkspace* adjustment,
            InitialHypothesis* h) {
  const InitialGeometryView view = h->view();
  InitialAdjustmentOptions options{.loss = InitialLoss::kCauchy,
                                   .width_sigma = kNarrow_sigmas,
                                   .sigma_scale = c.sigma_scale,
                                   .rotations_fixed = c.rotations_fixed};
  const InitialFit before = evaluate_initial(observations, view, options, adjustment);
  options.iterations_max = iterations.wide;
  options.width_sigma =
      std::clamp(kNarrow_sigmas * std::sqrt(before.median), kNarrow_sigmas, kWideMax_sigmas);
  (void)adjust_initial(observations, view, options, adjustment);
  options.iterations_max = iterations.narrow;
  options.width_sigma = kNarrow_sigmas;
  (void)adjust_initial(observations, view, options, adjustment);
  h->fit = adjust_initial(observations, view, selection_loss(c, iterations.last), adjustment);
  return normalise_gauge(view) && std::isfinite(h->fit.cost);
}

/// Inserts a hypothesis. Of two with the same geometry only the one of lower cost stays.
void insert_distinct(const InitialHypothesis& h, InitialHypotheses* list) {
  for (InitialHypothesis& known : *list) {
    if (same_geometry(known, h, kSameGeometry)) {
      if (h.fit.cost < known.fit.cost) {
        known = h;
      }
      return;
    }
  }
  (void)list->push_back(h);
}

InitialHypothesis depth_reversed(const InitialHypothesis& h) {
  InitialHypothesis reversed = h;
  reversed.reversed = !h.reversed;
  apply_depth_reversal(reversed.view());
  (void)normalise_gauge(reversed.view());
  return reversed;
}

/// Refines seeds, first without their depth-reversed solutions. Seeds with the same minimum, or
/// with depth-reversed minima, are one family.
void refine_families(const Selection& c, InitialWorkspace* w) {
  const std::span<const TrackObservation> core = w->core_observations.view();
  InitialHypotheses& families = w->refined;
  families.clear();
  for (InitialHypothesis& seed : w->seeds) {
    if (!normalise_gauge(seed.view()) || !refine(c, core, kSeedIterations, &w->adjustment, &seed)) {
      continue;
    }
    const InitialHypothesis reversed = depth_reversed(seed);
    const bool is_reversed =
        std::any_of(families.begin(), families.end(), [&](const InitialHypothesis& f) {
          return same_geometry(f, reversed, kSameGeometry) && f.fit.cost <= seed.fit.cost;
        });
    if (!is_reversed) {
      insert_distinct(seed, &families);
    }
  }
  sort_by_cost(&families);
}

/// Both solutions of the best families, refined on the core to convergence, the best first.
void refine_both_depths(const Selection& c, InitialWorkspace* w) {
  const std::span<const TrackObservation> core = w->core_observations.view();
  w->seeds.clear();
  for (std::size_t i = 0; i < std::min(kFamilies, w->refined.size()); ++i) {
    (void)w->seeds.push_back(w->refined[i]);
    (void)w->seeds.push_back(depth_reversed(w->refined[i]));
  }
  w->refined.clear();
  for (InitialHypothesis& h : w->seeds) {
    if (refine(c, core, kFamilyIterations, &w->adjustment, &h)) {
      insert_distinct(h, &w->refined);
    }
  }
  sort_by_cost(&w->refined);
}

/// Residual noise of the best hypothesis over the caller's sigma, at least 1.
double noise_scale(const InitialHypotheses& refined, double sigma_scale) {
  const double scale = refined.empty() ? kNoiseScaleMax : sigma_scale * refined[0].fit.noise_scale;
  return std::clamp(scale, 1.0, kNoiseScaleMax);
}

/// Adds the best hypotheses of one core to the finalists.
void select_on_core(const InitialCore& core, Selection* c, InitialWorkspace* w) {
  const SelectionSet& set = w->set;
  w->core_observations.clear();
  for (const TrackObservation& s : set.observations) {
    const bool seen =
        std::find(core.frames.begin(), core.frames.end(), s.frame) != core.frames.end();
    if (seen && std::find(core.tracks.begin(), core.tracks.end(), s.track) != core.tracks.end()) {
      (void)w->core_observations.push_back(s);
    }
  }
  seed_hypotheses({.times_s = c->problem.times_s,
                   .observations = set.observations.view(),
                   .selection_tracks = set.tracks.size(),
                   .core = &core,
                   .seed = c->problem.seed,
                   .kinds = c->problem.kinds},
                  &w->seeds);
  c->sigma_scale = 1.0;
  refine_families(*c, w);
  c->sigma_scale = noise_scale(w->refined, c->sigma_scale);
  refine_both_depths(*c, w);
  c->sigma_scale = noise_scale(w->refined, c->sigma_scale);
  const std::size_t share = kFinalists / set.cores.size();
  for (std::size_t i = 0; i < std::min(share, w->refined.size()); ++i) {
    (void)w->finalists.push_back(w->refined[i]);
  }
}

/// Extends a hypothesis to all frames, with adjustments on the way, so that errors do not add up.
bool extend_to_all(const Selection& c, InitialWorkspace* w, InitialHypothesis* h) {
  const std::span<const TrackObservation> all = w->set.observations.view();
  const std::span<const TrackObservation> first = all.first(w->set.extension_observations);
  for (std::size_t step = 0; step < h->frames; ++step) {
    if (!extend(first, c.problem.times_s, kExtendRounds, h)) {
      break;
    }
    if (!refine(c, first, kExtendIterations, &w->adjustment, h)) {
      return false;
    }
  }
  add_points(all, h);
  return refine(c, all, kExtendedIterations, &w->adjustment, h);
}

/// Finalists, extended to all frames and compared on all observations of the selection.
void refine_finalists(const Selection& c, InitialWorkspace* w) {
  w->refined.clear();
  for (InitialHypothesis& h : w->finalists) {
    if (extend_to_all(c, w, &h)) {
      insert_distinct(h, &w->refined);
    }
  }
  sort_by_cost(&w->refined);
}

/// Compares the winner with its depth-reversed solution, refined from the winner's final geometry:
/// else a rival might lose in a wrong local minimum.
void compare_with_reversed(const Selection& c, InitialWorkspace* w) {
  for (int round = 0; round < kReversalRounds && !w->refined.empty(); ++round) {
    InitialHypothesis reversed = depth_reversed(w->refined[0]);
    if (!refine_to_minimum(c, w->set.observations.view(), &w->adjustment, &reversed)) {
      return;
    }
    const bool wins = reversed.fit.cost < w->refined[0].fit.cost;
    insert_distinct(reversed, &w->refined);
    sort_by_cost(&w->refined);
    if (!wins) {
      return;
    }
  }
}

/// Cost margin of the winner to `rival`: the smaller of the plain difference and of one with a
/// bound on each track's share. The latter is zero where the tracks do not agree.
double cost_margin_to(const Selection& c,
                      std::span<const TrackObservation> observations,
                      InitialHypothesis* winner,
                      InitialHypothesis* rival) {
  std::array<double, limits::kSelectionTracks> of_winner;
  std::array<double, limits::kSelectionTracks> of_rival;
  const InitialAdjustmentOptions options = selection_loss(c, 0);
  const std::size_t tracks = winner->tracks;
  initial_track_costs(observations, winner->view(), options, std::span(of_winner).first(tracks));
  initial_track_costs(observations, rival->view(), options, std::span(of_rival).first(tracks));
  double plain = 0.0;
  double clipped = 0.0;
  double clipped2 = 0.0;
  for (std::size_t i = 0; i < tracks; ++i) {
    const double difference = of_rival[i] - of_winner[i];
    const double bounded = std::clamp(difference, -kTrackMarginMax, kTrackMarginMax);
    plain += difference;
    clipped += bounded;
    clipped2 += bounded * bounded;
  }
  const double scatter =
      std::sqrt(std::max(0.0, clipped2 - clipped * clipped / static_cast<double>(tracks)));
  const double agreed = clipped < kAgreementMin * scatter ? 0.0 : clipped;
  const double noise = std::max(1.0, winner->fit.noise_scale);
  return std::min(plain, agreed) / (noise * noise);
}

int middle_frame(const SelectionSet& set) {
  const InitialCore& core = set.cores[set.cores.size() - 1];
  return core.frames[core.frames.size() / 2];
}

/// Where the costs do not decide, a convex hypothesis comes before a hollow one. The cost margin is
/// negative then.
void prefer_convex(const InitialOptions& options, InitialWorkspace* w) {
  InitialHypotheses& list = w->refined;
  if (list.empty() || convexity_of(w->set, &list[0]) > -kConvexityMin) {
    return;
  }
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].fit.cost - list[0].fit.cost < options.chi2_gap_convexity &&
        convexity_of(w->set, &list[i]) >= kConvexityMin) {
      std::swap(list[0], list[i]);
      return;
    }
  }
}

}  // namespace

bool refine_to_minimum(const Selection& c,
                       std::span<const TrackObservation> observations,
                       InitialAdjustmentWorkspace* adjustment,
                       InitialHypothesis* h) {
  return refine(c, observations, kReversedIterations, adjustment, h);
}

InitialAdjustmentOptions selection_loss(const Selection& c, int iterations_max) {
  return {.iterations_max = iterations_max,
          .loss = InitialLoss::kTruncated,
          .width_sigma = kTruncation_sigmas,
          .sigma_scale = c.sigma_scale,
          .rotations_fixed = c.rotations_fixed};
}

double convexity_of(const SelectionSet& set, InitialHypothesis* h) {
  return convexity_cue(set.observations.view(), middle_frame(set), h->view());
}

double cost_margin_of(const Selection& c, InitialWorkspace* w) {
  InitialHypotheses& list = w->refined;
  // Without a rival: the margin to the cost of no explanation at all.
  double margin =
      kTruncation_sigmas * kTruncation_sigmas * list[0].fit.observations - list[0].fit.cost;
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (!same_geometry(list[0], list[i], kDifferentGeometry)) {
      margin = std::min(margin, cost_margin_to(c, w->set.observations.view(), &list[0], &list[i]));
    }
  }
  return margin;
}

void select_hypotheses(Selection* selection, InitialWorkspace* w) {
  w->finalists.clear();
  double scale = kNoiseScaleMax;
  for (const InitialCore& core : w->set.cores) {
    select_on_core(core, selection, w);
    scale = std::min(scale, selection->sigma_scale);
  }
  selection->sigma_scale = scale;
  refine_finalists(*selection, w);
  compare_with_reversed(*selection, w);
  prefer_convex(selection->options, w);
}

}  // namespace polhode
