#include "initialisation/collect.hpp"

#include <algorithm>
#include <cmath>

namespace polhode {
namespace {

struct PictureChange {
  int matches = 0;
  double shift_px = 0.0;     ///< mean motion
  double relative_px = 0.0;  ///< RMS motion about the mean
  double extent_px = 0.0;    ///< RMS distance of the features from their mean
};

PictureChange change_since(const CollectedFrame& before,
                           const Features& now,
                           double ratio_max,
                           FeatureMatches* matches) {
  match_mutual(before.features.view(), now.view(), ratio_max, matches);
  PictureChange change;
  change.matches = static_cast<int>(matches->size());
  if (matches->empty()) {
    return change;
  }
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double squares = 0.0;
  double place_squares = 0.0;
  for (const FeatureMatch& match : *matches) {
    const Feature& a = before.features[static_cast<std::size_t>(match.a)];
    const Feature& b = now[static_cast<std::size_t>(match.b)];
    const Eigen::Vector2d at(a.u_px, a.v_px);
    const Eigen::Vector2d d = Eigen::Vector2d(b.u_px, b.v_px) - at;
    sum += d;
    squares += d.squaredNorm();
    place += at;
    place_squares += at.squaredNorm();
  }
  const double n = change.matches;
  change.shift_px = (sum / n).norm();
  change.relative_px = std::sqrt(std::max(0.0, squares / n - (sum / n).squaredNorm()));
  change.extent_px = std::sqrt(std::max(0.0, place_squares / n - (place / n).squaredNorm()));
  return change;
}

/// Is the frame different enough from the last collected one to tell something about depth?
bool worth_collecting(const Features& features, double ratio_max, TrackTable* tracks) {
  if (tracks->frames.empty()) {
    return true;
  }
  const PictureChange change =
      change_since(tracks->frames.back(), features, ratio_max, &tracks->scratch);
  // A turn of 2 deg moves a body's near spots by 3 % of its radius against its far ones; a shift of
  // a fifth of the radius changes the direction of view by as much as matters for translation
  // alone.
  constexpr double kRelativeMin = 0.03;
  constexpr double kShiftMin = 0.2;
  constexpr int kMatchesFew = 30;
  return change.matches < kMatchesFew || change.relative_px > kRelativeMin * change.extent_px ||
         change.shift_px > kShiftMin * change.extent_px;
}

}  // namespace

Collected collect_frame(const CollectibleFrame& frame,
                        double ratio_max,
                        InitialisationState* state) {
  constexpr std::size_t kFeaturesMin = 12;  // fewer cannot carry a pose
  if (frame.features->size() < kFeaturesMin ||
      !worth_collecting(*frame.features, ratio_max, &state->tracks)) {
    return {};
  }
  add_frame(
      frame.frame, frame.timestamp_ns, frame.R_IC, *frame.features, ratio_max, &state->tracks);
  constexpr std::size_t kConnectingMin = 8;  // fewer cannot carry a start
  drop_unconnected_frames(kConnectingMin, &state->tracks);
  const Collected collected{.kept = true, .tables_full = state->tracks.full_count};
  state->tracks.full_count = 0;
  return collected;
}

void pose_problem(const InitialisationState& state,
                  const CameraModel& camera,
                  const StartOptions& options,
                  std::uint64_t seed,
                  StartJob* job) {
  static_assert(limits::kStartFrames <= 64);
  const TrackTable& table = state.tracks;
  job->frame_count = table.frames.size();
  job->track_count = table.tracks.size();
  job->seed = seed;
  job->options = options;
  for (std::size_t i = 0; i < job->frame_count; ++i) {
    const std::int64_t since_ns = table.frames[i].timestamp_ns - table.frames[0].timestamp_ns;
    job->times_s[i] = static_cast<double>(since_ns) * 1e-9;
  }
  for (std::size_t t = 0; t < job->track_count; ++t) {
    StartTrack& track = job->tracks[t];
    track.observations.clear();
    for (const TrackPoint& point : table.tracks[t].points) {
      const Feature& f = table.frames[static_cast<std::size_t>(point.frame)]
                             .features[static_cast<std::size_t>(point.feature)];
      (void)track.observations.push_back(
          {.frame = point.frame,
           .normalised = f.normalised,
           .sigma_normalised = static_cast<double>(f.sigma_px) / camera.focal_px()});
    }
  }
}

}  // namespace polhode
