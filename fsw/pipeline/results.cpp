#include "pipeline/results.hpp"

#include <algorithm>
#include <utility>

#include "base/assert.hpp"
#include "bus/event_reports.hpp"
#include "pipeline/begin.hpp"
#include "pipeline/counting.hpp"
#include "pipeline/map_update.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

// An initialisation is followed by two adjustments, each of which ends before the next begins.
constexpr int kJobsInARowMax = 4;

void take_fit_result(const FitJob& job, const MapDrift& drift, MotionEstimate* motion) {
  take_fit(job.model, job.snapshot.poses.back().timestamp_ns, job.poses_new, drift, motion);
}

void take_shape_result(const ShapeJob& work,
                       ShapeState* shape,
                       Counters* counters,
                       bus::EventLog* events) {
  ++counters->shapes;
  if (take_shape(work, shape->frame_asked, shape)) {
    bus::event::shape_known({.points = static_cast<std::uint32_t>(work.outcome->cloud_points),
                             .planes = static_cast<std::uint32_t>(work.outcome->planes.size())},
                            events);
  }
}

/// Reads the scale from a shape with a configured length.
void read_scale_of_shape(const Shape& shape,
                         const ScaleOptions& options,
                         const MapDrift& drift,
                         ScaleState* scale,
                         Counters* counters) {
  // A rectangle ends at its outermost points, and a map of one aspect is bent. Lengths are
  // therefore read only of a body that was seen over a quarter turn.
  constexpr double kAcross_rad = 1.57;
  if ((shape.box || shape.cylinder) && drift.turn_rad > kAcross_rad) {
    count(read_scale_of(shape, options, scale), counters);
  }
}

/// Skipped, or the solver found no usable solution.
bool is_without_result(const Job& job, const JobQueue& jobs) {
  return job.skipped || (is_out_with<AdjustmentJob>(job) && !jobs.adjustment.usable);
}

void take_result(Job* job, Component::State* s) {
  POLHODE_ASSERT(job->done, job->due_step);
  s->counters.jobs_without_result += is_without_result(*job, s->jobs) ? 1 : 0;
  const JobWork work = std::exchange(job->work, std::monostate{});
  if (job->unwanted) {
    return;
  }
  if (std::holds_alternative<InitialisationJob*>(work)) {
    take_start(s);
  } else if (std::holds_alternative<AdjustmentJob*>(work)) {
    take_adjustment(s);
  } else if (std::holds_alternative<FitJob*>(work)) {
    if (!job->skipped) {
      take_fit_result(s->jobs.fit_work, s->mapping.drift, &s->motion);
    }
  } else if (std::holds_alternative<CameraJob*>(work)) {
    if (!job->skipped) {
      take_camera_test(s->jobs.camera.fit, &s->camera);
    }
  } else if (job->skipped) {
    ask_shape_again(&s->shape);
  } else if (const ShapeJob& shape = s->jobs.shape_work; shape.outcome) {
    take_shape_result(shape, &s->shape, &s->counters, &s->bus.events);
    const ScaleOptions& options = s->configuration.parameters.scale;
    read_scale_of_shape(*shape.outcome, options, s->mapping.drift, &s->scale, &s->counters);
  }
  stage_done(Stage::kJobs, s->timer);
}

void take_if_due(Job* job, const Jobs& finished, Component::State* s) {
  const bool handed_in = std::find(finished.begin(), finished.end(), job) != finished.end();
  const bool due = is_out(*job) && s->clock.frame >= job->due_step;
  // The caller waits for a late job before it steps: without that, results would depend on time.
  POLHODE_ASSERT(handed_in == due, s->clock.frame);
  if (due) {
    take_result(job, s);
  }
}

/// A new map is adjusted within the step. Tracked while it is still bent, a body that rotates by 10
/// deg a frame is lost before its other aspects have landmarks. An initialisation with more frames
/// than these is of a body that shows the same aspect for longer. Its adjustments take several
/// times as long as a step, and run beside the steps.
bool begins_within_step(const Component::State& s) {
  // An adjustment of 20 to 32 keyframes takes 0.1 to 0.2 s. Chosen
  constexpr std::uint32_t kKeyframesMost = 12;
  const AdjustmentJob& job = s.jobs.adjustment;
  return is_out_with<AdjustmentJob>(s.jobs.map) && job.reason != AdjustmentReason::kMapGrown &&
         s.mapping.map.next_keyframe_number - job.first_keyframe <= kKeyframesMost;
}

/// @param due_step_max  a job that is due later stays out.
void run_and_take(std::uint32_t due_step_max, Job* job, Component::State* s) {
  for (int i = 0; i < kJobsInARowMax && is_out(*job) && job->due_step <= due_step_max; ++i) {
    if (!job->done) {
      run_job(*job);
    }
    take_result(job, s);
  }
}

void close_job(Job* job, Component::State* s) {
  run_and_take(UINT32_MAX, job, s);
  POLHODE_ASSERT(!is_out(*job), job->due_step);
}

}  // namespace

void take_due_jobs(const Jobs& finished, Component::State* s) {
  JobQueue& jobs = s->jobs;
  take_if_due(&jobs.map, finished, s);
  take_if_due(&jobs.fit, finished, s);
  take_if_due(&jobs.shape, finished, s);
  if (begins_within_step(*s)) {
    close_job(&jobs.map, s);
  }
  run_undelayed(&jobs.map, s);  // a window, after an adjustment of the whole map
}

void run_undelayed(Job* job, Component::State* s) { run_and_take(s->clock.frame, job, s); }

void close_jobs(Component::State* s) {
  close_job(&s->jobs.map, s);
  close_job(&s->jobs.fit, s);
  close_job(&s->jobs.shape, s);
}

}  // namespace polhode
