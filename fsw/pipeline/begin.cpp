#include "pipeline/begin.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "map/begin.hpp"
#include "map/keyframes.hpp"
#include "map/reanchor.hpp"
#include "pipeline/adjustment.hpp"
#include "pipeline/map_update.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

std::int64_t frames_with_pose(const InitialOutcome& start) {
  return std::count_if(
      start.frames.begin(), start.frames.end(), [](const InitialFramePose& f) { return f.valid; });
}

// Residuals along a track are correlated, so variances are three times as large (decision 0083).
constexpr double kAlike = 3.0;

void start_drift(const InitialOutcome& start, const Similarity& to_T, MapDrift* drift) {
  const auto first = std::find_if(
      start.frames.begin(), start.frames.end(), [](const InitialFramePose& f) { return f.valid; });
  begin_drift(transformed(first->pose, to_T).R_CT,
              start.rotation_rad,
              std::sqrt(kAlike) * start.depth_sigma,
              to_T.scale,
              drift);
}

/// Puts the initialisation's keyframes and landmarks into the map and requests a first joint
/// adjustment. Landmarks beyond the initialisation's tracks follow after it, with a second one.
void take_over_start(const Similarity& to_T, Component::State* s) {
  const InitialOutcome& start = s->jobs.start.outcome;
  const CameraModel& camera = s->configuration.camera;
  Map& map = s->mapping.map;
  s->jobs.adjustment.first_keyframe = map.next_keyframe_number;
  begin_map({.outcome = &start,
             .first_frame = s->jobs.start.first_frame,
             .tracks = &s->initialisation.tracks,
             .to_T = to_T},
            s->configuration.parameters.map,
            &map);
  refresh_landmarks(&map, camera);
  ask_for_adjustment_of_all(
      AdjustmentReason::kMapBegun, adjustment_view(*s), &s->mapping, &s->jobs);
  start_drift(start, to_T, &s->mapping.drift);
  change_mode(ModeEvent::kMapBegun, &s->mode);
}

using ReanchorFrames = FixedVector<ReanchorFrame, limits::kInitialFrames>;

/// Poses of the initialisation, paired with those predicted by the motion before the loss.
ReanchorFrames predicted_beside(const InitialOutcome& start,
                                std::span<const CollectedFrame> collected_frames,
                                const MotionEstimate& motion,
                                const MapDrift& drift,
                                const MotionOptions& options) {
  ReanchorFrames frames;
  for (std::size_t f = 0; f < start.frames.size(); ++f) {
    if (!start.frames[f].valid) {
      continue;
    }
    const CollectedFrame& collected = collected_frames[f];
    const auto predicted =
        predict_or_hold(motion, drift, options, collected.timestamp_ns, collected.R_IC);
    if (predicted) {
      (void)frames.push_back(
          {.start = start.frames[f].pose,
           .predicted = predicted->pose,
           .predicted_sigma_rad = worst_sigma(predicted->covariance.topLeftCorner<3, 3>()),
           .predicted_sigma_mu = worst_sigma(predicted->covariance.bottomRightCorner<3, 3>())});
    }
  }
  return frames;
}

bool has_room(const InitialOutcome& start, const MapOptions& options, const Map& map) {
  return map.keyframe_count + frames_with_pose(start) <= options.keyframes_max &&
         static_cast<std::size_t>(map.landmark_count) + start.points.size() <= limits::kLandmarks;
}

/// The first map, or another one with a T and a unit of its own.
void begin(Component::State* s) {
  reset_map_and_motion(s);
  s->scale = {};
  ++s->mapping.target_frame;
  take_over_start({}, s);
}

/// After a loss. T stays: the motion so far re-anchors the new initialisation in it, and the
/// published sigmas grow by the uncertainty of that motion. The old map stays beside the new part
/// and joins it at a loop closure. It is dropped when the tables have no room for both. The new map
/// gets a T of its own where the motion is uncertain or contradicts the initialisation, which was
/// decided without it.
void begin_again(Component::State* s) {
  const InitialOutcome& start = s->jobs.start.outcome;
  const Parameters& parameters = s->configuration.parameters;
  MapState& mapping = s->mapping;
  const ReanchorFrames frames =
      predicted_beside(start,
                       s->initialisation.tracks.frames.view().subspan(s->jobs.start.first_frame),
                       s->motion,
                       mapping.drift,
                       parameters.motion);
  const Result<Reanchoring> found = reanchor_map(
      frames.view(), {.centre_T = mapping.map.centre_T, .radius_mu = mapping.map.radius_mu});
  ++s->counters.restarts;
  const bool doubted = s->motion.departures > 0;
  if (doubted || !found || !found.value().agrees) {
    begin(s);
    return;
  }
  const Reanchoring& found_T = found.value();
  // Uncertainty of T: the prediction's error at the first frame, where it is least, and the misfit
  // over the initialisation.
  add_reanchoring(std::hypot(frames[0].predicted_sigma_rad, found_T.misfit_rad),
                  0.5 * mapping.map.radius_mu,
                  mapping.map.next_keyframe_number,
                  &mapping.drift);
  s->counters.keyframes_culled += static_cast<std::uint32_t>(
      make_room(static_cast<int>(start.frames.size()), parameters.map, &mapping.map));
  if (!has_room(start, parameters.map, mapping.map)) {
    const MapDrift drift = mapping.drift;  // of T, which stays
    reset_map_and_motion(s);
    mapping.drift = drift;
  }
  take_over_start(found_T.to_T, s);
}

}  // namespace

void take_start(Component::State* s) {
  const InitialisationJob& job = s->jobs.start;
  if (job.outcome.decision != InitialDecision::kCommit) {
    if (job.outcome.crowded && s->initialisation.tracks.frames.size() == job.frame_count) {
      drop_oldest_frame(&s->initialisation.tracks);
    }
    return;
  }
  if (s->mode.now == Mode::kAcquiring) {
    begin(s);
  } else if (s->mode.now == Mode::kLost) {  // else relocalised in the meantime
    begin_again(s);
  }
}

}  // namespace polhode
