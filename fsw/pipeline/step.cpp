// One step, the stages in the order that data travels.
#include <algorithm>
#include <cmath>

#include "pipeline/acquire.hpp"
#include "pipeline/commands.hpp"
#include "pipeline/frame_uses.hpp"
#include "pipeline/motion_jobs.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/publish.hpp"
#include "pipeline/results.hpp"
#include "pipeline/scale_now.hpp"
#include "pipeline/shape_now.hpp"
#include "pipeline/state.hpp"
#include "pipeline/telemetry.hpp"
#include "pipeline/track.hpp"

namespace polhode {
namespace {

/// May the frame be looked at? Where the time before it was wrong nothing that has a time can stay,
/// neither poses nor keyframes.
FrameUse admit(const Frame& frame, Component::State* s) {
  const bool rises = !s->time_known || frame.timestamp_ns > s->timestamp_ns;
  if (!rises && !outvotes(frame.timestamp_ns, &s->time_doubt)) {
    return s->bus.held ? FrameUse::kHeld : FrameUse::kTimeNotIncreasing;
  }
  if (!rises) {
    forget_target(s);
    s->arrivals = {};
    s->timestamp_ns = frame.timestamp_ns;  // whatever becomes of its picture
  }
  s->time_doubt = {};
  s->counters.frames_missing +=
      static_cast<std::uint32_t>(missing_frames(frame.timestamp_ns, &s->arrivals));
  return s->bus.held ? FrameUse::kHeld : FrameUse::kUsed;
}

/// What became of a frame, and what was wrong with its picture.
void count(FrameUse use, const FrameVerdict& verdict, Counters* counters) {
  if (const auto counter = row_of(use).counter) {
    ++(counters->*counter);
  }
  counters->frames_with_care += verdict.decision == FrameDecision::kCare ? 1 : 0;
  if (const FrameFaultRow* const fault = row_of(verdict.fault)) {
    ++(counters->*fault->counter);
  }
}

/// Memory that was short comes back when less is asked for; after a second or so of frames it is
/// tried again in full.
void shed_load(bool memory_short, Component::State* s) {
  constexpr std::uint32_t kSteps = 30;
  if (memory_short) {
    s->steps_to_shed = kSteps;
  } else if (s->steps_to_shed > 0) {
    --s->steps_to_shed;
  }
  s->counters.steps_short_of_memory += s->steps_to_shed > 0 ? 1 : 0;
}

void estimate(const std::optional<PosePrediction>& predicted, Component::State* s) {
  if (s->mode == Mode::kAcquiring) {
    collect(s);
  } else {
    track(predicted, s);
  }
  stage_done(Stage::kMap, *s);
  run_undelayed(&s->job, s);
  measure_scale(s);
  ask_for_shape(s);
  run_undelayed(&s->shape_job, s);
  stage_done(Stage::kShape, *s);
  if (s->pose_valid) {
    remember_motion(
        s->timestamp_ns, s->localised.absolute.pose, s->localised.absolute.covariance, s);
    run_undelayed(&s->fit_job, s);
    widen_turn(s->localised.absolute.pose, &s->drift);
    ++s->counters.poses;
  }
  stage_done(Stage::kMotion, *s);
}

}  // namespace

const StepOutput& Component::step(const StepInput& input) {
  State* s = state_;
  s->frame = s->next_frame++;
  begin_telemetry(s);
  execute_commands(input.commands, s);
  ++s->counters.frames_in;
  s->pose_valid = false;
  shed_load(input.memory_short, s);
  s->map_moved_rad = 0.0;
  take_due_jobs(input.finished, s);
  if (s->bus.held) {
    s->mode = Mode::kIdle;
  }
  forget_picture(s);
  if (s->mode == Mode::kIdle && !s->bus.held) {
    s->mode = Mode::kAcquiring;
  }
  set_observer(input, s);
  FrameUse use = admit(input.frame, s);
  if (use == FrameUse::kUsed) {
    use = take_picture(input.frame, s);
  }
  if (row_of(use).looked_at) {
    s->timestamp_ns = input.frame.timestamp_ns;
    s->time_known = true;
  }
  if (use == FrameUse::kUsed) {
    const std::optional<PosePrediction> predicted =
        predict_or_hold(s->motion, s->drift, s->parameters.motion, s->timestamp_ns, s->motion.R_IC);
    look_for_target(predicted, s);
    estimate(predicted, s);
  } else if (s->mode == Mode::kTracking) {
    s->reference.valid = false;
  }
  count(use, s->verdict, &s->counters);
  publish(use, input.frame.timestamp_ns, s);
  stage_done(Stage::kBus, *s);
  return s->output;
}

}  // namespace polhode
