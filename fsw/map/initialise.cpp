#include "map/initialise.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "geometry/so3.hpp"
#include "map/start_extend.hpp"

namespace polhode {
namespace {

// Geometries that differ by less than this are one answer: a quarter is what "right" means in the start's benchmark.
constexpr double kSameGeometry = 0.15;
constexpr double kDifferentGeometry = 0.20;
constexpr std::size_t kFamilies = 6;   // seeds that go on to full refinement, with their twins
constexpr std::size_t kFinalists = 6;  // hypotheses that are grown to all frames, shared by the cores
constexpr int kExtendRounds = 3;       // frames posed on either side between two adjustments
constexpr int kTwinRounds = 3;
// A quarter of the depth is wrong with 3 sigma at most.
constexpr double kDepthSigmaMax = 0.08;
// Tracks go wrong in 5 to 20 % of cases, and take their sightings with them.
constexpr double kInlierRatioMin = 0.6;
// The caller's sigma may be wrong by this factor before the fit itself is in doubt.
constexpr double kNoiseScaleMax = 4.0;
// A track's share in a gap: more comes from a wrong track that one hypothesis happens to explain.
constexpr double kTrackGapMax = 4.0;
// A chi-square gap of 25 scatters by 10: less agreement between the tracks than 1.5 sigma is no evidence.
constexpr double kAgreementMin = 1.5;
// Two standard deviations: the sign of the curvature is right in 98 % of cases.
constexpr double kConvexityMin = 2.0;

struct Contest {
  const StartProblem& problem;
  const StartOptions& options;
  StartWorkspace& w;
  double sigma_scale = 1.0;
};

void sort_by_cost(StartHypotheses* list) {
  std::stable_sort(list->begin(), list->end(),
                   [](const StartHypothesis& a, const StartHypothesis& b) { return a.fit.cost < b.fit.cost; });
}

StartAdjustmentOptions truncated(const Contest& c, int iterations_max) {
  return {.iterations_max = iterations_max,
          .loss = StartLoss::kTruncated,
          .width_sigma = 4.0,
          .sigma_scale = c.sigma_scale};
}

/// Cauchy loss as wide as the residuals are now, then as wide as noise, then the cost that is compared.
bool refine(const Contest& c, std::span<const StartSighting> sightings, int wide, int narrow, int last,
            StartHypothesis* h) {
  const StartGeometryView view = h->view();
  StartAdjustmentOptions options{.loss = StartLoss::kCauchy, .width_sigma = 3.0, .sigma_scale = c.sigma_scale};
  const StartFit before = evaluate_start(sightings, view, options, &c.w.adjustment);
  options.iterations_max = wide;
  options.width_sigma = std::clamp(3.0 * std::sqrt(before.median), 3.0, 300.0);
  (void)adjust_start(sightings, view, options, &c.w.adjustment);
  options.iterations_max = narrow;
  options.width_sigma = 3.0;
  (void)adjust_start(sightings, view, options, &c.w.adjustment);
  h->fit = adjust_start(sightings, view, truncated(c, last), &c.w.adjustment);
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

/// Seeds, first without their twins: those that lead to the same minimum, or to its twin, are one family.
void refine_families(const Contest& c) {
  const std::span<const StartSighting> core = c.w.core_sightings.view();
  StartHypotheses& families = c.w.refined;
  families.clear();
  for (StartHypothesis& seed : c.w.seeds) {
    if (!normalise_gauge(seed.view()) || !refine(c, core, 6, 4, 0, &seed)) {
      continue;
    }
    const StartHypothesis twin = twin_of(seed);
    const bool is_twin = std::any_of(families.begin(), families.end(), [&](const StartHypothesis& f) {
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
  const double scale = c.w.refined.empty() ? kNoiseScaleMax : c.sigma_scale * c.w.refined[0].fit.noise_scale;
  return std::clamp(scale, 1.0, kNoiseScaleMax);
}

/// Best hypotheses of one core go on to the finals.
void contest_core(const StartCore& core, Contest* c) {
  StartWorkspace& w = c->w;
  const StartContestSet& set = w.set;
  w.core_sightings.clear();
  for (const StartSighting& s : set.sightings) {
    const bool seen = std::find(core.frames.begin(), core.frames.end(), s.frame) != core.frames.end();
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
  return refine(c, all, 5, 10, 15, h);
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

/// The winner's own twin, started from the winner's final geometry: no rival loses for having stuck elsewhere.
void challenge_winner(const Contest& c) {
  for (int round = 0; round < kTwinRounds && !c.w.refined.empty(); ++round) {
    StartHypothesis twin = twin_of(c.w.refined[0]);
    if (!refine(c, c.w.set.sightings.view(), 8, 12, 20, &twin)) {
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

/// By how much `rival` fits worse than the winner: the smaller of the plain difference and of one in which no track
/// decides alone; none at all when the tracks do not agree on it.
double gap_to(const Contest& c, StartHypothesis* winner, StartHypothesis* rival) {
  std::array<double, kContestTracks> of_winner;
  std::array<double, kContestTracks> of_rival;
  const StartAdjustmentOptions options = truncated(c, 0);
  const std::size_t tracks = winner->tracks;
  start_track_costs(c.w.set.sightings.view(), winner->view(), options, std::span(of_winner).first(tracks));
  start_track_costs(c.w.set.sightings.view(), rival->view(), options, std::span(of_rival).first(tracks));
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
  const double scatter = std::sqrt(std::max(0.0, clipped2 - clipped * clipped / static_cast<double>(tracks)));
  const double agreed = clipped < kAgreementMin * scatter ? 0.0 : clipped;
  const double noise = std::max(1.0, winner->fit.noise_scale);
  return std::min(plain, agreed) / (noise * noise);
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

/// Winner's poses into the arrays of all tracks, points triangulated; tracks beyond the adjustment's capacity are left.
void spread_to_all_tracks(const Contest& c, StartHypothesis* winner) {
  StartWorkspace& w = c.w;
  w.sightings.clear();
  std::copy(winner->poses.begin(), winner->poses.end(), w.poses.begin());
  std::copy(winner->posed.begin(), winner->posed.end(), w.posed.begin());
  for (std::size_t i = 0; i < c.problem.tracks.size(); ++i) {
    w.known[i] = 0;
    const auto& observations = c.problem.tracks[i].observations;
    if (observations.size() < 2 ||
        w.sightings.size() + observations.size() > StartAdjustmentWorkspace::kSightings) {
      continue;
    }
    // One track at a time through the hypothesis's own table: its first slot serves as the bench.
    FixedVector<StartSighting, limits::kStartFrames> own;
    for (const StartObservation& o : observations) {
      StartSighting s{.frame = o.frame,
                      .track = 0,
                      .normalised = o.normalised,
                      .sigma_normalised = o.sigma_normalised};
      (void)own.push_back(s);
      s.track = static_cast<int>(i);
      (void)w.sightings.push_back(s);
    }
    winner->known[0] = 0;
    add_points(own.view(), winner);
    w.known[i] = winner->known[0];
    w.points_T[i] = winner->points_T[0];
  }
  for (std::size_t k = 0; k < w.set.tracks.size(); ++k) {
    const auto i = static_cast<std::size_t>(w.set.tracks[k]);
    if (k > 0 && winner->known[k] != 0) {
      w.known[i] = 1;
      w.points_T[i] = winner->points_T[k];
    }
  }
}

StartGeometryView all_tracks_view(const Contest& c) {
  const std::size_t frames = c.problem.times_s.size();
  const std::size_t tracks = c.problem.tracks.size();
  return {std::span(c.w.poses).first(frames), std::span(c.w.posed).first(frames),
          std::span(c.w.points_T).first(tracks), std::span(c.w.known).first(tracks)};
}

/// Points that at least two sightings, and half of them, agree on stay known.
void drop_wrong_tracks(const Contest& c, StartOutcome* out) {
  const double limit2 = 16.0 * c.sigma_scale * c.sigma_scale;
  std::array<int, limits::kStartTracks> agree{};
  for (const StartSighting& s : c.w.sightings) {
    Eigen::Vector2d x;
    const auto track = static_cast<std::size_t>(s.track);
    const auto frame = static_cast<std::size_t>(s.frame);
    if (c.w.known[track] != 0 && c.w.posed[frame] != 0 && reproject(c.w.poses[frame], c.w.points_T[track], &x) &&
        (x - s.normalised).squaredNorm() < limit2 * s.sigma_normalised * s.sigma_normalised) {
      ++agree[track];
    }
  }
  for (std::size_t i = 0; i < c.problem.tracks.size(); ++i) {
    const auto sightings = static_cast<int>(c.problem.tracks[i].observations.size());
    const bool good = c.w.known[i] != 0 && agree[i] >= 2 && 2 * agree[i] >= sightings;
    c.w.known[i] = good ? 1 : 0;
    out->points[i].inliers = good ? agree[i] : 0;
  }
}

double median_depth_sigma(const Contest& c) {
  FixedVector<double, limits::kStartTracks> sigma;
  for (std::size_t i = 0; i < c.problem.tracks.size(); ++i) {
    if (c.w.known[i] != 0) {
      (void)sigma.push_back(std::sqrt(std::max(0.0, c.w.covariances[i](2, 2))));
    }
  }
  if (sigma.empty()) {
    return 1e300;
  }
  std::nth_element(sigma.begin(), sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2), sigma.end());
  return sigma[sigma.size() / 2];
}

/// All tracks together with all poses; fills poses, points and covariances.
void adjust_all_tracks(const Contest& c, StartOutcome* out) {
  StartHypothesis winner = c.w.refined[0];
  spread_to_all_tracks(c, &winner);
  const StartGeometryView view = all_tracks_view(c);
  out->points.resize(c.problem.tracks.size());
  out->frames.resize(c.problem.times_s.size());
  out->depth_sigma = 1e300;
  drop_wrong_tracks(c, out);
  (void)adjust_start(c.w.sightings.view(), view, truncated(c, 10), &c.w.adjustment);
  drop_wrong_tracks(c, out);
  if (!normalise_gauge(view)) {
    return;
  }
  const std::span covariances = std::span(c.w.covariances).first(c.problem.tracks.size());
  if (!start_point_covariances(c.w.sightings.view(), view, truncated(c, 0), covariances, &c.w.adjustment)) {
    return;
  }
  out->depth_sigma = median_depth_sigma(c);
  for (std::size_t i = 0; i < out->points.size(); ++i) {
    StartPoint& point = out->points[i];
    point.p_T = c.w.points_T[i];
    point.covariance_T = c.w.covariances[i];
    point.valid = c.w.known[i] != 0 && point.covariance_T.allFinite() && point.covariance_T.diagonal().minCoeff() > 0.0;
  }
  Eigen::Matrix3d R_first = Eigen::Matrix3d::Identity();
  for (std::size_t f = 0; f < out->frames.size(); ++f) {
    if (c.w.posed[f] != 0) {
      out->frames[f] = {.valid = true, .pose = from_inverse_depth(c.w.poses[f])};
      out->rotation_rad = std::max(out->rotation_rad, rotation_angle_rad(R_first, out->frames[f].pose.R_CT));
    }
  }
}

StartDecision decide(const StartOutcome& out, const StartOptions& options, double noise_scale) {
  if (out.inlier_ratio < kInlierRatioMin || noise_scale > kNoiseScaleMax) {
    return StartDecision::kNoHypothesis;
  }
  if (!(out.depth_sigma < kDepthSigmaMax)) {
    return StartDecision::kTooLittleMotion;
  }
  const bool clear = out.chi2_gap >= options.chi2_gap_commit;
  const bool likely = out.chi2_gap >= options.chi2_gap_convexity && out.convexity >= kConvexityMin;
  return clear || likely ? StartDecision::kCommit : StartDecision::kTwinsTooClose;
}

int middle_frame(const StartContestSet& set) {
  const StartCore& core = set.cores[set.cores.size() - 1];
  return core.frames[core.frames.size() / 2];
}

double convexity_of(const Contest& c, StartHypothesis* h) {
  return convexity_cue(c.w.set.sightings.view(), middle_frame(c.w.set), h->view());
}

/// Where the costs leave it open, a bulging hypothesis goes before a hollow one. The gap, negative then, still says so.
void prefer_convex(const Contest& c) {
  StartHypotheses& list = c.w.refined;
  if (list.empty() || convexity_of(c, &list[0]) > -kConvexityMin) {
    return;
  }
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].fit.cost - list[0].fit.cost < c.options.chi2_gap_convexity && convexity_of(c, &list[i]) >= kConvexityMin) {
      std::swap(list[0], list[i]);
      return;
    }
  }
}

}  // namespace

double convexity_cue(std::span<const StartSighting> sightings, int frame, const StartGeometryView& geometry) {
  if (geometry.posed[static_cast<std::size_t>(frame)] == 0) {
    return 0.0;
  }
  const InverseDepthPose& pose = geometry.poses[static_cast<std::size_t>(frame)];
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  double zz = 0.0;
  int count = 0;
  for (const StartSighting& s : sightings) {
    const auto track = static_cast<std::size_t>(s.track);
    if (s.frame != frame || geometry.known[track] == 0 || geometry.points_T[track].norm() > 4.0) {
      continue;
    }
    const Eigen::Vector3d q = pose.R_CT * geometry.points_T[track];
    const Eigen::Vector4d row(1.0, q.x(), q.y(), q.head<2>().squaredNorm());
    H += row * row.transpose();
    g += row * q.z();
    zz += q.z() * q.z();
    ++count;
  }
  if (count < 8) {
    return 0.0;
  }
  const Eigen::Vector4d fit = H.ldlt().solve(g);
  // An exact plane has no curvature to speak of: depths are never known better than a thousandth of the extent.
  const double variance = std::max(1e-6, (zz - fit.dot(g)) / (count - 4));
  return fit(3) / std::sqrt(variance * H.inverse()(3, 3));
}

StartOutcome run_start_contest(const StartProblem& problem, const StartOptions& options, StartWorkspace& workspace) {
  StartOutcome out;
  if (!select_contest_set(problem, &workspace.set)) {
    return out;
  }
  Contest contest{.problem = problem, .options = options, .w = workspace};
  const StartContestSet& set = workspace.set;
  workspace.finalists.clear();
  double scale = kNoiseScaleMax;
  for (const StartCore& core : set.cores) {
    contest_core(core, &contest);
    scale = std::min(scale, contest.sigma_scale);
  }
  contest.sigma_scale = scale;
  refine_finalists(contest);
  challenge_winner(contest);
  prefer_convex(contest);
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
