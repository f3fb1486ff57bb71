#include "pipeline/shape_now.hpp"

#include <algorithm>

#include "bus/shape_telemetry.hpp"
#include "map/landmarks.hpp"
#include "pipeline/jobs.hpp"
#include "pipeline/scale_now.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

/// A known diameter or edge waits for a shape.
bool scale_is_awaited(const Component::State& s) {
  const ScaleOptions& options = s.parameters.scale;
  return !s.scale.known && (options.known_diameter_m != 0.0 || options.known_edge_m != 0.0);
}

/// Between two estimates; while one is awaited, sooner: a young map has few confirmed landmarks.
std::uint32_t frames_between(const Component::State& s) {
  const auto every = static_cast<std::uint32_t>(s.parameters.bus.shape_every_frames);
  return s.shape.shape && !scale_is_awaited(s) ? every : std::max(1U, every / 5);
}

bool wants_shape(const Component::State& s) {
  const ShapeState& now = s.shape;
  return s.mode == Mode::kTracking && shape_slot_free(s) &&
         s.map.next_keyframe_number != now.keyframe_asked &&
         (!now.asked || s.frame - now.frame_asked >= frames_between(s));
}

void tell_change(const std::optional<Shape>& before, const Shape& now, Component::State* s) {
  const bool same =
      before && before->planes.size() == now.planes.size() && before->completion == now.completion;
  if (!same) {
    bus::report(
        bus::EventId::kShapeKnown,
        {.values = {static_cast<double>(now.cloud_points), static_cast<double>(now.planes.size())}},
        &s->bus.events);
  }
}

}  // namespace

void ask_for_shape(Component::State* s) {
  if (!wants_shape(*s)) {
    return;
  }
  ShapeState& now = s->shape;
  ShapeJob& job = s->shape_job;
  job.landmarks_T.clear();
  for (const Landmark& landmark : s->map.landmarks) {
    if (landmark.used && confirmed(landmark)) {
      (void)job.landmarks_T.push_back(landmark.p_T);
    }
  }
  job.options = s->parameters.shape;
  job.seed = s->parameters.seed;
  job.previous = now.shape;
  job.outcome.reset();
  now.asked = true;
  now.frame_asked = s->frame;
  now.keyframe_asked = s->map.next_keyframe_number;
  issue_shape(s);
}

void take_shape(Component::State* s) {
  const ShapeJob& job = s->shape_job;
  if (job.skipped) {
    s->shape.keyframe_asked =
        0;  // a body that is mapped all around may never give another keyframe
  }
  if (!job.outcome) {
    return;
  }
  ++s->counters.shapes;
  tell_change(s->shape.shape, *job.outcome, s);
  s->shape.shape = job.outcome;
  s->shape.frame_of_estimate = job.issued_step;
  s->shape.is_new = true;
  // A rectangle ends where its points do, and what was seen from one side is bent: only a whole
  // body has known lengths.
  constexpr double kAcross_rad = 1.57;
  if ((job.outcome->box || job.outcome->cylinder) && s->drift.turn_rad > kAcross_rad) {
    (void)measure_scale_of(*job.outcome, s);
  }
}

void forget_shape(Component::State* s) {
  s->shape = {};
  s->shape_job.unwanted = true;
}

void send_shape(const MotionState& motion, Component::State* s) {
  ShapeState& now = s->shape;
  const bool due =
      motion.frame % static_cast<std::uint32_t>(s->parameters.bus.shape_every_frames) == 0;
  if (!now.shape || !(now.is_new || due)) {
    return;
  }
  now.is_new = false;
  bus::ShapePacket packet = bus::to_packet(*now.shape, length_unit(*s));
  packet.timestamp_ns = motion.timestamp_ns;
  packet.frame = motion.frame;
  packet.frame_of_estimate = now.frame_of_estimate;
  append(packet, s->parameters.bus, &s->bus.stream);
}

}  // namespace polhode
