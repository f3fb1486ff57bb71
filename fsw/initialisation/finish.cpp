// From the winner of the selection to poses, points and covariances of all tracks.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/median.hpp"
#include "geometry/so3.hpp"
#include "initialisation/extend.hpp"
#include "initialisation/selection.hpp"

namespace polhode {
namespace {

// Chosen: the winner has settled on its own tracks; the others begin from triangulation.
constexpr int kIterations = 10;
// Above every limit of a depth's sigma.
constexpr double kUnknownSigma = 1e300;

/// Copies the winner's poses and triangulates all tracks. Tracks beyond the adjustment's capacity
/// are skipped.
void spread_to_all_tracks(const Selection& c, InitialWorkspace* w, InitialHypothesis* winner) {
  w->observations.clear();
  std::copy(winner->poses.begin(), winner->poses.end(), w->poses.begin());
  std::copy(winner->posed.begin(), winner->posed.end(), w->posed.begin());
  for (std::size_t i = 0; i < c.problem.tracks.size(); ++i) {
    w->known[i] = 0;
    const auto& observations = c.problem.tracks[i].observations;
    if (observations.size() < 2 || w->observations.size() + observations.size() >
                                       InitialAdjustmentWorkspace::kInitialObservations) {
      continue;
    }
    // One track at a time: the first slot of the hypothesis is the workspace of add_points().
    FixedVector<TrackObservation, limits::kInitialFrames> own;
    for (const InitialObservation& o : observations) {
      TrackObservation s{.frame = o.frame,
                         .track = 0,
                         .normalised = o.normalised,
                         .sigma_normalised = o.sigma_normalised};
      (void)own.push_back(s);
      s.track = static_cast<int>(i);
      (void)w->observations.push_back(s);
    }
    winner->known[0] = 0;
    add_points(own.view(), winner);
    w->known[i] = winner->known[0];
    w->points_T[i] = winner->points_T[0];
  }
  for (std::size_t k = 0; k < w->set.tracks.size(); ++k) {
    const auto i = static_cast<std::size_t>(w->set.tracks[k]);
    if (k > 0 && winner->known[k] != 0) {
      w->known[i] = 1;
      w->points_T[i] = winner->points_T[k];
    }
  }
}

InitialGeometryView all_tracks_view(const InitialProblem& problem, InitialWorkspace* w) {
  const std::size_t frames = problem.times_s.size();
  const std::size_t tracks = problem.tracks.size();
  return {std::span(w->poses).first(frames),
          std::span(w->posed).first(frames),
          std::span(w->points_T).first(tracks),
          std::span(w->known).first(tracks)};
}

/// Keeps the points that agree with at least two of their observations, and with half of them.
void drop_wrong_tracks(const Selection& c, InitialWorkspace* w, InitialOutcome* out) {
  const double limit2 = kTruncation_sigmas * kTruncation_sigmas * c.sigma_scale * c.sigma_scale;
  std::array<int, limits::kInitialTracks> agree{};
  for (const TrackObservation& s : w->observations) {
    Eigen::Vector2d x;
    const auto track = static_cast<std::size_t>(s.track);
    const auto frame = static_cast<std::size_t>(s.frame);
    if (w->known[track] != 0 && w->posed[frame] != 0 &&
        reproject(w->poses[frame], w->points_T[track], &x) &&
        (x - s.normalised).squaredNorm() < limit2 * s.sigma_normalised * s.sigma_normalised) {
      ++agree[track];
    }
  }
  for (std::size_t i = 0; i < c.problem.tracks.size(); ++i) {
    const auto observations = static_cast<int>(c.problem.tracks[i].observations.size());
    const bool good = w->known[i] != 0 && agree[i] >= 2 && 2 * agree[i] >= observations;
    w->known[i] = good ? 1 : 0;
    out->points[i].inliers = good ? agree[i] : 0;
  }
}

/// @param tracks  only known ones count.
template <typename Tracks>
double median_depth_sigma(const Tracks& tracks, const InitialWorkspace& w) {
  FixedVector<double, limits::kInitialTracks> sigma;
  for (const int track : tracks) {
    const auto i = static_cast<std::size_t>(track);
    if (w.known[i] != 0) {
      (void)sigma.push_back(std::sqrt(std::max(0.0, w.covariances[i](2, 2))));
    }
  }
  return sigma.empty() ? kUnknownSigma : median(sigma.view());
}

}  // namespace

void adjust_all_tracks(const Selection& c, InitialWorkspace* w, InitialOutcome* out) {
  InitialHypothesis winner = w->refined[0];
  spread_to_all_tracks(c, w, &winner);
  const InitialGeometryView view = all_tracks_view(c.problem, w);
  out->points.resize(c.problem.tracks.size());
  out->frames.resize(c.problem.times_s.size());
  out->depth_sigma = out->selection_depth_sigma = kUnknownSigma;
  drop_wrong_tracks(c, w, out);
  (void)adjust_initial(
      w->observations.view(), view, selection_loss(c, kIterations), &w->adjustment);
  drop_wrong_tracks(c, w, out);
  if (!normalise_gauge(view)) {
    return;
  }
  const std::span covariances = std::span(w->covariances).first(c.problem.tracks.size());
  if (!initial_point_covariances(
          w->observations.view(), view, selection_loss(c, 0), covariances, &w->adjustment)) {
    return;
  }
  FixedVector<int, limits::kInitialTracks> all;
  all.resize(c.problem.tracks.size());
  std::iota(all.begin(), all.end(), 0);
  out->depth_sigma = median_depth_sigma(all, *w);
  // The cores' tracks are the longest, and decide on the geometry. On a body that rotates fast most
  // other tracks last three or four frames and have uncertain depths (decision 0031).
  FixedVector<int, 2 * kCoreTracks> in_cores;
  for (const InitialCore& core : w->set.cores) {
    for (const int track : core.tracks) {
      (void)in_cores.push_back(w->set.tracks[static_cast<std::size_t>(track)]);
    }
  }
  out->selection_depth_sigma = median_depth_sigma(in_cores, *w);
  for (std::size_t i = 0; i < out->points.size(); ++i) {
    InitialPoint& point = out->points[i];
    point.p_T = w->points_T[i];
    point.covariance_T = w->covariances[i];
    point.valid = w->known[i] != 0 && point.covariance_T.allFinite() &&
                  point.covariance_T.diagonal().minCoeff() > 0.0;
  }
  Eigen::Matrix3d R_first = Eigen::Matrix3d::Identity();
  for (std::size_t f = 0; f < out->frames.size(); ++f) {
    if (w->posed[f] != 0) {
      out->frames[f] = {.valid = true, .pose = from_inverse_depth(w->poses[f])};
      out->rotation_rad =
          std::max(out->rotation_rad, rotation_angle_rad(R_first, out->frames[f].pose.R_CT));
    }
  }
}

}  // namespace polhode
