#include "initialisation/selection.hpp"

#include <algorithm>
#include <cmath>

#include "initialisation/convexity.hpp"
#include "initialisation/extend.hpp"
#include "initialisation/hypotheses.hpp"

namespace polhode {
namespace {

// Geometries that differ by less than this are one answer: a quarter is what "right" means in the
// start's benchmark.
constexpr double kSameGeometry = 0.15;
constexpr double kDifferentGeometry = 0.20;
constexpr std::size_t kFamilies = 6;  // seeds that go on to full refinement, with their twins
constexpr std::size_t kFinalists =
    6;                            // hypotheses that are grown to all frames, shared by the cores
constexpr int kExtendRounds = 3;  // frames posed on either side between two adjustments
constexpr int kTwinRounds = 3;
// Depth and turn make up for each other along a valley in which steps are short: a hypothesis that
// has not come to its floor is no rival, but would be waited for. Most settle in a tenth of this.
constexpr int kSettleIterations = 60;
// A track's share in a gap: more comes from a wrong track that one hypothesis happens to explain.
constexpr double kTrackGapMax = 4.0;
// A chi-square gap of 25 scatters by 10: less agreement between the tracks than 1.5 sigma is no
// evidence.
constexpr double kAgreementMin = 1.5;

void sort_by_cost(StartHypotheses* list) {
  std::stable_sort(
      list->begin(), list->end(), [](const StartHypothesis& a, const StartHypothesis& b) {
        return a.fit.cost < b.fit.cost;
      });
}

/// Cauchy loss as wide as the residuals are now, then as wide as noise, then the cost that is
/// compared.
bool refine(const Contest& c,
            std::span<const StartSighting> sightings,
            int wide,
            int narrow,
            int last,
            StartHypothesis* h) {
  const StartGeometryView view = h->view();
  StartAdjustmentOptions options{
      .loss = StartLoss::kCauchy, .width_sigma = 3.0, .sigma_scale = c.sigma_scale};
  const StartFit before = evaluate_start(sightings, view, options, &c.w.adjustment);
  options.iterations_max = wide;
  options.width_sigma = std::clamp(3.0 * std::sqrt(before.median), 3.0, 300.0);
  (void)adjust_start(sightings, view, options, &c.w.adjustment);
  options.iterations_max = narrow;
  options.width_sigma = 3.0;
  (void)adjust_start(sightings, view, options, &c.w.adjustment);
  h->fit = adjust_start(sightings, view, contest_loss(c, last), &c.w.adjustment);
  return normalise_gauge(view) && std::isfinite(h->fit.cost);
}

/// Inserts unless a hypothesis of the same geometry is there; of two equals the cheaper stays.
void insert_distinct(const StartHypothesis& h, StartHypotheses* list) {
  for (StartHypothesis& known : *list) {
    if (same_geometry(known, h, kSameGeometry)) {
      if (h.fit.cost < known.fit.cost) {
        known = h;
      }
      return;
    }
  }
  (void)list->push_back(h);
}

StartHypothesis twin_of(const StartHypothesis& h) {
  StartHypothesis twin = h;
  twin.reversed = !h.reversed;
  reverse_depth(twin.view());
  (void)normalise_gauge(twin.view());
  return twin;
}

/// Seeds, first without their twins: those that lead to the same minimum, or to its twin, are one
/// family.
void refine_families(const Contest& c) {
  const std::span<const StartSighting> core = c.w.core_sightings.view();
  StartHypotheses& families = c.w.refined;
  families.clear();
  for (StartHypothesis& seed : c.w.seeds) {
    if (!normalise_gauge(seed.view()) || !refine(c, core, 6, 4, 0, &seed)) {
      continue;
    }
    const StartHypothesis twin = twin_of(seed);
    const bool is_twin =
        std::any_of(families.begin(), families.end(), [&](const StartHypothesis& f) {
          return same_geometry(f, twin, kSameGeometry) && f.fit.cost <= seed.fit.cost;
        });
    if (!is_twin) {
      insert_distinct(seed, &families);
    }
  }
  sort_by_cost(&families);
}

/// Both twins of the best families, refined on the core to convergence, the best first.
void refine_twins(const Contest& c) {
  const std::span<const StartSighting> core = c.w.core_sightings.view();
  c.w.seeds.clear();
  for (std::size_t i = 0; i < std::min(kFamilies, c.w.refined.size()); ++i) {
    (void)c.w.seeds.push_back(c.w.refined[i]);
    (void)c.w.seeds.push_back(twin_of(c.w.refined[i]));
  }
  c.w.refined.clear();
  for (StartHypothesis& h : c.w.seeds) {
    if (refine(c, core, 8, 10, 15, &h)) {
      insert_distinct(h, &c.w.refined);
    }
  }
  sort_by_cost(&c.w.refined);
}

/// The noise is at least what the caller says; more when the best hypothesis says so.
double noise_scale(const Contest& c) {
  const double scale =
      c.w.refined.empty() ? kNoiseScaleMax : c.sigma_scale * c.w.refined[0].fit.noise_scale;
  return std::clamp(scale, 1.0, kNoiseScaleMax);
}

/// Best hypotheses of one core go on to the finals.
void contest_core(const StartCore& core, Contest* c) {
  StartWorkspace& w = c->w;
  const StartContestSet& set = w.set;
  w.core_sightings.clear();
  for (const StartSighting& s : set.sightings) {
    const bool seen =
        std::find(core.frames.begin(), core.frames.end(), s.frame) != core.frames.end();
    if (seen && std::find(core.tracks.begin(), core.tracks.end(), s.track) != core.tracks.end()) {
      (void)w.core_sightings.push_back(s);
    }
  }
  seed_hypotheses({.times_s = c->problem.times_s,
                   .sightings = set.sightings.view(),
                   .contest_tracks = set.tracks.size(),
                   .core = &core,
                   .seed = c->problem.seed,
                   .kinds = c->problem.kinds},
                  &w.seeds);
  c->sigma_scale = 1.0;
  refine_families(*c);
  c->sigma_scale = noise_scale(*c);
  refine_twins(*c);
  c->sigma_scale = noise_scale(*c);
  const std::size_t share = kFinalists / set.cores.size();
  for (std::size_t i = 0; i < std::min(share, w.refined.size()); ++i) {
    (void)w.finalists.push_back(w.refined[i]);
  }
}

/// Grows a hypothesis to all frames, adjusting on the way so that errors do not add up.
bool grow(const Contest& c, StartHypothesis* h) {
  const std::span<const StartSighting> all = c.w.set.sightings.view();
  for (std::size_t step = 0; step < h->frames; ++step) {
    if (!extend(all, c.problem.times_s, kExtendRounds, h)) {
      break;
    }
    if (!refine(c, all, 3, 3, 0, h)) {
      return false;
    }
  }
  return refine(c, all, 5, 10, kSettleIterations, h);
}

/// Finalists grown to all frames and compared on all contest sightings.
void refine_finalists(const Contest& c) {
  c.w.refined.clear();
  for (StartHypothesis& h : c.w.finalists) {
    if (grow(c, &h)) {
      insert_distinct(h, &c.w.refined);
    }
  }
  sort_by_cost(&c.w.refined);
}

/// The winner's own twin, started from the winner's final geometry: no rival loses for having stuck
/// elsewhere.
void challenge_winner(const Contest& c) {
  for (int round = 0; round < kTwinRounds && !c.w.refined.empty(); ++round) {
    StartHypothesis twin = twin_of(c.w.refined[0]);
    if (!refine(c, c.w.set.sightings.view(), 8, 12, kSettleIterations, &twin)) {
      return;
    }
    const bool wins = twin.fit.cost < c.w.refined[0].fit.cost;
    insert_distinct(twin, &c.w.refined);
    sort_by_cost(&c.w.refined);
    if (!wins) {
      return;
    }
  }
}

/// By how much `rival` fits worse than the winner: the smaller of the plain difference and of one
/// in which no track decides alone; none at all when the tracks do not agree on it.
double gap_to(const Contest& c, StartHypothesis* winner, StartHypothesis* rival) {
  std::array<double, kContestTracks> of_winner;
  std::array<double, kContestTracks> of_rival;
  const StartAdjustmentOptions options = contest_loss(c, 0);
  const std::size_t tracks = winner->tracks;
  start_track_costs(
      c.w.set.sightings.view(), winner->view(), options, std::span(of_winner).first(tracks));
  start_track_costs(
      c.w.set.sightings.view(), rival->view(), options, std::span(of_rival).first(tracks));
  double plain = 0.0;
  double clipped = 0.0;
  double clipped2 = 0.0;
  for (std::size_t i = 0; i < tracks; ++i) {
    const double difference = of_rival[i] - of_winner[i];
    const double bounded = std::clamp(difference, -kTrackGapMax, kTrackGapMax);
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

int middle_frame(const StartContestSet& set) {
  const StartCore& core = set.cores[set.cores.size() - 1];
  return core.frames[core.frames.size() / 2];
}

/// Where the costs leave it open, a bulging hypothesis goes before a hollow one. The gap, negative
/// then, still says so.
void prefer_convex(const Contest& c) {
  StartHypotheses& list = c.w.refined;
  if (list.empty() || convexity_of(c, &list[0]) > -kConvexityMin) {
    return;
  }
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].fit.cost - list[0].fit.cost < c.options.chi2_gap_convexity &&
        convexity_of(c, &list[i]) >= kConvexityMin) {
      std::swap(list[0], list[i]);
      return;
    }
  }
}

}  // namespace

StartAdjustmentOptions contest_loss(const Contest& c, int iterations_max) {
  return {.iterations_max = iterations_max,
          .loss = StartLoss::kTruncated,
          .width_sigma = 4.0,
          .sigma_scale = c.sigma_scale};
}

double convexity_of(const Contest& c, StartHypothesis* h) {
  return convexity_cue(c.w.set.sightings.view(), middle_frame(c.w.set), h->view());
}

double chi2_gap(const Contest& c) {
  StartHypotheses& list = c.w.refined;
  // Without a rival the gap is that to having no explanation at all.
  double gap = 16.0 * list[0].fit.sightings - list[0].fit.cost;
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (!same_geometry(list[0], list[i], kDifferentGeometry)) {
      gap = std::min(gap, gap_to(c, &list[0], &list[i]));
    }
  }
  return gap;
}

void hold_contest(Contest* contest) {
  contest->w.finalists.clear();
  double scale = kNoiseScaleMax;
  for (const StartCore& core : contest->w.set.cores) {
    contest_core(core, contest);
    scale = std::min(scale, contest->sigma_scale);
  }
  contest->sigma_scale = scale;
  refine_finalists(*contest);
  challenge_winner(*contest);
  prefer_convex(*contest);
}

}  // namespace polhode
