// One step: the rooms in the order of the data flow.
#include <algorithm>
#include <optional>

#include "bus/frame_uses.hpp"
#include "map/track.hpp"
#include "pipeline/acquire.hpp"
#include "pipeline/coast.hpp"
#include "pipeline/commands.hpp"
#include "pipeline/counting.hpp"
#include "pipeline/observer.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/publish.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/results.hpp"
#include "pipeline/row_times.hpp"
#include "pipeline/scrub.hpp"
#include "pipeline/state.hpp"
#include "pipeline/target_model.hpp"
#include "pipeline/track.hpp"
#include "shape/scale_reading.hpp"

namespace polhode {
namespace {

/// A new frame, without features, matches or a pose yet.
void begin_step(Component::State* s) {
  s->clock.frame = s->clock.next_frame++;
  forget_frame(&s->mapping, &s->picture, &s->features);
  s->bus.stream.size = 0;
  s->answer.output.checkpoint_asked = false;
}

/// Reduced work frees memory that was short. After about a second of frames the full work is tried
/// again.
void shed_load(bool memory_short, std::uint32_t* steps_to_shed, Counters* counters) {
  constexpr std::uint32_t kSteps = 30;  // 1 to 3 s at 10 to 30 frames/s
  if (memory_short) {
    *steps_to_shed = kSteps;
  } else if (*steps_to_shed > 0) {
    --*steps_to_shed;
  }
  counters->steps_short_of_memory += *steps_to_shed > 0 ? 1 : 0;
}

/// Takes the frame's time, then its image, where they can be used.
FrameUse take_frame(const Frame& frame, Component::State* s) {
  std::uint32_t missing = 0;
  const Admission admission = admit(frame.timestamp_ns, &s->clock, &missing);
  s->counters.frames_missing += missing;
  if (admission == Admission::kTimeWasWrong) {
    reset_target(s);
  }
  if (s->mode.held) {
    return FrameUse::kHeld;
  }
  if (admission == Admission::kNotLater) {
    return FrameUse::kTimeNotIncreasing;
  }
  const Configuration& c = s->configuration;
  FrameUse use = bring_picture(frame, c.camera, &s->mapping.reference, &s->picture);
  if (use == FrameUse::kUsed) {
    use = judge_picture(c.parameters.image, &s->picture);
    stage_done(Stage::kImage, s->timer);
  }
  if (row_of(use).looked_at) {
    if (!s->clock.time_known && s->mapping.map.keyframe_count > 0) {
      date_target_model(frame.timestamp_ns, &s->mapping.map, &s->motion);
    }
    s->clock.timestamp_ns = frame.timestamp_ns;
    s->clock.time_known = true;
  }
  return use;
}

void locate_target(const std::optional<PosePrediction>& predicted, Component::State* s) {
  prepare_flow(s->picture.gray, &s->mapping);
  if (s->mode.now == Mode::kAcquiring) {
    collect(s);
  } else {
    track(predicted, s);
  }
  stage_done(Stage::kMap, s->timer);
  run_undelayed(&s->jobs.map, s);
}

/// Issues a prepared test of the camera, when no estimate of the shape is out.
void test_camera(JobTimes times, CameraState* camera, JobQueue* jobs) {
  if (camera->waits && !is_out(jobs->shape)) {
    times.delay = std::max(times.delay, times.delay_of_all);
    issue_job(&jobs->camera, times, &jobs->shape, jobs);
    camera->waits = false;
  }
}

/// Reads the scale, and issues an estimate of the shape where one is due.
void measure_target(Component::State* s) {
  const Configuration& c = s->configuration;
  const ScaleOptions& options = c.parameters.scale;
  if (s->mapping.pose_valid) {
    count(read_scale(s->clock.timestamp_ns, s->mapping, scale_input(*s), &s->scale), &s->counters);
  }
  // More often while a known diameter or edge waits for a shape: a young map has few confirmed
  // landmarks.
  const bool scale_is_awaited =
      !s->scale.known && (options.known_diameter_m != 0.0 || options.known_edge_m != 0.0);
  const auto every = static_cast<std::uint32_t>(c.parameters.bus.shape_every_frames);
  const std::uint32_t frames_between =
      s->shape.shape && !scale_is_awaited ? every : std::max(1U, every / 5);
  if (s->mode.now == Mode::kTracking && !is_out(s->jobs.shape) &&
      shape_is_due(s->shape, s->mapping.map, s->clock.frame, frames_between)) {
    prepare_shape(s->mapping.map,
                  c.parameters.shape,
                  c.parameters.seed,
                  s->clock.frame,
                  &s->shape,
                  &s->jobs.shape_work);
    issue_job(&s->jobs.shape_work, job_times(*s), &s->jobs.shape, &s->jobs);
  }
  run_undelayed(&s->jobs.shape, s);
  test_camera(job_times(*s), &s->camera, &s->jobs);
  stage_done(Stage::kShape, s->timer);
}

/// Adds the pose to the motion; the dynamics are fitted again when that is due.
void estimate_motion(Component::State* s) {
  if (s->mapping.pose_valid) {
    const MotionOptions& options = s->configuration.parameters.motion;
    const AbsolutePose& found = s->mapping.localised.absolute;
    const bool fit_is_due =
        s->mapping.pose_updates_motion &&
        remember_pose(s->clock.timestamp_ns, found.pose, found.covariance, options, &s->motion);
    if (fit_is_due && !is_out(s->jobs.fit)) {
      prepare_fit(s->mapping.map, s->mapping.drift, options, &s->motion, &s->jobs.fit_work);
      issue_job(&s->jobs.fit_work, job_times(*s), &s->jobs.fit, &s->jobs);
    }
    run_undelayed(&s->jobs.fit, s);
    widen_turn(found.pose, &s->mapping.drift);
    ++s->counters.poses;
  }
  stage_done(Stage::kMotion, s->timer);
}

}  // namespace

const StepOutput& Component::step(const StepInput& input) {
  State* s = state_;
  begin_step(s);
  scrub(s);
  execute_commands(input.commands, s);
  ++s->counters.frames_in;
  shed_load(input.memory_short, &s->steps_to_shed, &s->counters);
  take_due_jobs(input.finished, s);
  change_mode(ModeEvent::kFrameComes, &s->mode);
  set_observer(input, s);
  const FrameUse use = take_frame(input.frame, s);
  if (use == FrameUse::kUsed) {
    const std::optional<PosePrediction> predicted =
        predict_or_hold(s->motion,
                        s->mapping.drift,
                        s->configuration.parameters.motion,
                        s->clock.timestamp_ns,
                        s->motion.R_IC);
    const Configuration& c = s->configuration;
    const Pose* tracked = has_target(s->mode) && predicted ? &predicted->pose : nullptr;
    look_for_target(tracked, s->mapping.map, c.camera, c.parameters.mask, &s->picture);
    stage_done(Stage::kMask, s->timer);
    s->features.image_motion = expected_image_motion(s->clock.timestamp_ns, *s);
    locate_target(predicted, s);
    measure_target(s);
    estimate_motion(s);
  } else if (use != FrameUse::kTimeNotIncreasing) {
    coast(input.frame.timestamp_ns, s);
  }
  count(use, s->picture.verdict, &s->counters);
  take_counts(&s->mapping.counts, &s->jobs.counts, &s->counters);
  publish(use, input.frame.timestamp_ns, s);
  stage_done(Stage::kBus, s->timer);
  return s->answer.output;
}

}  // namespace polhode
