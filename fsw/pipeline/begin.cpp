#include "pipeline/begin.hpp"

#include <algorithm>
#include <cmath>

#include "map/begin.hpp"
#include "map/bridge.hpp"
#include "map/keyframes.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/motion_jobs.hpp"
#include "pipeline/shape_now.hpp"

namespace polhode {
namespace {

void start_drift(const Similarity& to_T, Component::State* s) {
  const StartOutcome& start = s->job.start.outcome;
  const auto first = std::find_if(
      start.frames.begin(), start.frames.end(), [](const StartFramePose& f) { return f.valid; });
  begin_drift(transformed(first->pose, to_T).R_CT,
              start.rotation_rad,
              start.depth_sigma,
              to_T.scale,
              &s->drift);
}

/// The start's keyframes and landmarks into the map, and a first joint adjustment asked for.
void take_over_start(const Similarity& to_T, Component::State* s) {
  const std::uint32_t first_keyframe = s->map.next_keyframe_number;
  begin_map(s->job.start.outcome, s->initialisation.tracks, to_T, s->parameters.map, &s->map);
  settle_map(first_keyframe, s);
  start_drift(to_T, s);
  s->mode = Mode::kTracking;
}

void forget_map(Component::State* s) {
  clear(&s->map);
  forget_motion(s);
  forget_shape(s);
  s->growth = {};
  s->last_adjustment_of_all = {};
}

/// The start's poses beside those that the motion before the loss predicts for the same times.
FixedVector<BridgeFrame, limits::kStartFrames> predicted_beside(const Component::State& s) {
  FixedVector<BridgeFrame, limits::kStartFrames> frames;
  for (std::size_t f = 0; f < s.job.start.outcome.frames.size(); ++f) {
    if (!s.job.start.outcome.frames[f].valid) {
      continue;
    }
    const auto predicted = predict_or_hold(s.motion,
                                           s.drift,
                                           s.parameters.motion,
                                           s.initialisation.tracks.frames[f].timestamp_ns,
                                           s.initialisation.tracks.frames[f].R_IC);
    if (predicted) {
      (void)frames.push_back(
          {.start = s.job.start.outcome.frames[f].pose,
           .predicted = predicted->pose,
           .predicted_sigma_rad = worst_sigma(predicted->covariance.topLeftCorner<3, 3>()),
           .predicted_sigma_mu = worst_sigma(predicted->covariance.bottomRightCorner<3, 3>())});
    }
  }
  return frames;
}

bool has_room(const Component::State& s) {
  const auto posed = std::count_if(s.job.start.outcome.frames.begin(),
                                   s.job.start.outcome.frames.end(),
                                   [](const StartFramePose& f) { return f.valid; });
  return s.map.keyframe_count + posed <= s.parameters.map.keyframes_max &&
         static_cast<std::size_t>(s.map.landmark_count) + s.job.start.outcome.points.size() <=
             limits::kLandmarks;
}

/// What the bridge leaves open of T: the prediction's own error at the first frame, where it is
/// least, and the disagreement over the start.
void widen_drift(const Bridge& bridge, double predicted_sigma_rad, Component::State* s) {
  const double attitude_rad = std::hypot(predicted_sigma_rad, bridge.misfit_rad);
  add_bridge(attitude_rad, 0.5 * s->map.radius_mu, s->map.next_keyframe_number, &s->drift);
}

/// The first map, or another one with a T and a unit of its own.
void begin(Component::State* s) {
  forget_map(s);
  forget_scale(&s->scale);
  s->drift = {};
  ++s->target_frame;
  take_over_start({}, s);
}

/// After a loss. T stays: the new start is bridged to it by the motion so far, and the published
/// sigmas grow by what that motion leaves open. The old map stays beside the new part, and joins it
/// when one of its sides comes back; it goes when the tables have no room for both. Where too
/// little is known of the motion, or it contradicts the new start's, which was decided on its own,
/// nothing ties the new start to T.
void begin_again(Component::State* s) {
  const auto frames = predicted_beside(*s);
  const Result<Bridge> found =
      bridge_start(frames.view(), {.centre_T = s->map.centre_T, .radius_mu = s->map.radius_mu});
  ++s->counters.restarts;
  if (!found || !found.value().agrees) {
    begin(s);
    return;
  }
  const Bridge& bridge = found.value();
  widen_drift(bridge, frames[0].predicted_sigma_rad, s);
  s->counters.keyframes_culled += static_cast<std::uint32_t>(
      make_room(static_cast<int>(s->job.start.outcome.frames.size()), s->parameters.map, &s->map));
  if (!has_room(*s)) {
    forget_map(s);
  }
  take_over_start(bridge.to_T, s);
}

}  // namespace

void take_start(Component::State* s) {
  const StartJob& job = s->job.start;
  if (job.outcome.decision != StartDecision::kCommit) {
    if (job.outcome.crowded && s->initialisation.tracks.frames.size() == job.frame_count) {
      drop_oldest_frame(&s->initialisation.tracks);
    }
    return;
  }
  if (s->mode == Mode::kAcquiring) {
    begin(s);
  } else if (s->mode == Mode::kLost) {  // else a known side has come back in the meantime
    begin_again(s);
  }
}

}  // namespace polhode
