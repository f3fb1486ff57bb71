#include "initialisation/collect.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/validity.hpp"
#include "initialisation/row_times.hpp"

namespace polhode {
namespace {

// A spot that is missed in one frame is found again: tracks that reach the last two are alive.
constexpr std::int32_t kEnd = 2;

struct ImageChange {
  int matches = 0;
  double shift_px = 0.0;     ///< mean motion
  double relative_px = 0.0;  ///< RMS motion about the mean
  double extent_px = 0.0;    ///< RMS distance of the features from their mean
};

ImageChange change_since(const CollectedFrame& before,
                         const Features& now,
                         double ratio_max,
                         FeatureMatches* matches) {
  match_mutual(before.features.view(), now.view(), ratio_max, matches);
  ImageChange change;
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

/// Is the frame different enough from the last collected one to constrain depth?
bool worth_collecting(const Features& features, double ratio_max, TrackTable* tracks) {
  if (tracks->frames.empty()) {
    return true;
  }
  const ImageChange change =
      change_since(tracks->frames.back(), features, ratio_max, &tracks->scratch);
  // A rotation of 2 deg moves a body's near points against its far ones by 3 % of its radius. For
  // translation alone, a shift of a fifth of the radius changes the direction of view as much.
  constexpr double kRelativeMin = 0.03;
  constexpr double kShiftMin = 0.2;
  constexpr int kMatchesFew = 30;
  return change.matches < kMatchesFew || change.relative_px > kRelativeMin * change.extent_px ||
         change.shift_px > kShiftMin * change.extent_px;
}

/// Factor on a feature's sigma as a point of a track: a change of the patch's appearance moves its
/// centre (decision 0066).
double sigma_factor(const TrackPoint& point) {
  constexpr double kLike2 = 200.0 * 200.0;  // the sigma of a feature is right up to here
  return std::max(1.0, static_cast<double>(point.distance2) / kLike2);
}

/// Numbers of tracks that reach the newest frames, by their first frame.
using BegunIn = std::array<std::size_t, limits::kInitialFrames>;

BegunIn count_alive(const TrackTable& table) {
  const auto frames = static_cast<std::int32_t>(table.frames.size());
  BegunIn begun{};
  for (const Track& track : table.tracks) {
    if (!track.points.empty() && track.points.back().frame >= frames - kEnd) {
      ++begun[static_cast<std::size_t>(track.points[0].frame)];
    }
  }
  return begun;
}

/// The first of the newest frames that enough tracks span from end to end.
std::size_t first_spanned(const TrackTable& table, int frames_min) {
  // Tracks that a comparison needs (decision 0030), or a third of all: a window that fewer span is
  // long, and the search in it harder. Chosen.
  constexpr std::size_t kSpanningMin = 40;
  constexpr std::size_t kPart = 3;
  const BegunIn begun = count_alive(table);
  const std::size_t alive = std::accumulate(begun.begin(), begun.end(), std::size_t{0});
  const std::size_t frames = table.frames.size();
  const std::size_t latest = frames - std::min(frames, static_cast<std::size_t>(frames_min));
  std::size_t spanning = begun[0];
  for (std::size_t first = 0; first < latest; ++first) {
    spanning += begun[first + 1];  // the beginning may be kEnd frames wide
    if (spanning >= std::max(kSpanningMin, alive / kPart)) {
      return first;
    }
  }
  return latest;
}

}  // namespace

void clear(InitialisationState* state) {
  clear(&state->tracks);
  state->asked_short = false;
  state->since_asked = 0;
}

bool is_valid(const InitialisationState& state) {
  return validity::is_bool(state.asked_short) && is_valid(state.tracks);
}

Collected collect_frame(const CollectibleFrame& frame,
                        const CameraModel& camera,
                        double ratio_max,
                        InitialisationState* state,
                        RestingPlaces* resting) {
  constexpr std::size_t kFeaturesMin = 12;  // fewer cannot carry a pose
  if (frame.features->size() < kFeaturesMin ||
      !worth_collecting(*frame.features, ratio_max, &state->tracks)) {
    return {};
  }
  add_frame(frame, ratio_max, &state->tracks);
  drop_resting_tracks(&state->tracks, resting);
  to_frame_time(camera, &state->tracks);
  constexpr std::size_t kConnectingMin = 8;  // too few for an initialisation
  drop_unconnected_frames(kConnectingMin, &state->tracks);
  const Collected collected{.kept = true, .tables_full = state->tracks.full_count};
  state->tracks.full_count = 0;
  ++state->since_asked;
  return collected;
}

bool wants_selection(const InitialOptions& options, const InitialisationState& state) {
  // One more frame of many adds little, and a selection over many takes long. Chosen: with fewer
  // than twelve frames each new one requests a selection.
  constexpr int kPart = 12;
  const auto frames = static_cast<int>(state.tracks.frames.size());
  return frames >= options.frames_min && state.since_asked > frames / kPart;
}

void pose_problem(const CameraModel& camera,
                  const InitialOptions& options,
                  std::uint64_t seed,
                  InitialisationState* state,
                  InitialisationJob* job) {
  static_assert(limits::kInitialFrames <= 64);
  const TrackTable& table = state->tracks;
  state->since_asked = 0;
  const std::size_t first = first_spanned(table, options.frames_min);
  state->asked_short = !state->asked_short && first > 0;
  job->first_frame = state->asked_short ? first : 0;
  job->frame_count = table.frames.size() - job->first_frame;
  job->track_count = table.tracks.size();
  job->seed = seed;
  job->images.camera = camera;
  job->options = options;
  for (std::size_t i = 0; i < job->frame_count; ++i) {
    const std::int64_t since_ns = table.frames[job->first_frame + i].timestamp_ns -
                                  table.frames[job->first_frame].timestamp_ns;
    job->times_s[i] = static_cast<double>(since_ns) * 1e-9;
    job->R_IC[i] = table.frames[job->first_frame + i].R_IC;
    job->images.crop_of[i] = static_cast<std::int8_t>(
        find_crop(table.frames[job->first_frame + i].frame, job->images.crops));
  }
  for (std::size_t t = 0; t < job->track_count; ++t) {
    InitialTrack& track = job->tracks[t];
    track.observations.clear();
    TrackPlaces& places = job->images.places[t];
    places.frames = 0;
    for (const TrackPoint& point : table.tracks[t].points) {
      const int frame = point.frame - static_cast<int>(job->first_frame);
      if (frame < 0) {
        continue;
      }
      const Feature& f = feature_of(point, table);
      places.frames |= 1U << static_cast<unsigned>(frame);
      places.px[static_cast<std::size_t>(frame)] = {f.u_px, f.v_px};
      (void)track.observations.push_back(
          {.frame = frame,
           .normalised = f.normalised,
           .sigma_normalised =
               sigma_factor(point) * static_cast<double>(f.sigma_px) / camera.focal_px()});
    }
  }
}

}  // namespace polhode
