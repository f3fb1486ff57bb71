#include "pipeline/results.hpp"

#include <algorithm>
#include <utility>

#include "base/assert.hpp"
#include "pipeline/begin.hpp"
#include "pipeline/counting.hpp"
#include "pipeline/map_update.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

// A start is followed by two adjustments, each of which ends before the next begins.
constexpr int kJobsInARowMax = 4;

void take_fit_result(bool skipped, Component::State* s) {
  const FitJob& job = s->jobs.fit_work;
  if (!skipped) {
    take_fit(job.model,
             job.snapshot.poses.back().timestamp_ns,
             job.poses_new,
             s->mapping.drift,
             &s->motion);
  }
}

void take_shape_result(const Job& job, Component::State* s) {
  const ShapeJob& work = s->jobs.shape_work;
  if (job.skipped) {
    ask_shape_again(&s->shape);
  }
  if (!work.outcome) {
    return;
  }
  ++s->counters.shapes;
  if (take_shape(work, s->shape.frame_asked, &s->shape)) {
    bus::report(bus::EventId::kShapeKnown,
                {.values = {static_cast<double>(work.outcome->cloud_points),
                            static_cast<double>(work.outcome->planes.size())}},
                &s->bus.events);
  }
  // A rectangle ends where its points do, and what was seen from one aspect is bent: only a body
  // that was seen over a quarter turn has known lengths.
  constexpr double kAcross_rad = 1.57;
  if ((work.outcome->box || work.outcome->cylinder) && s->mapping.drift.turn_rad > kAcross_rad) {
    const ScaleOptions& options = s->configuration.parameters.scale;
    count(read_scale_of(*work.outcome, options, &s->scale), &s->counters);
  }
}

void take_camera_result(bool skipped, Component::State* s) {
  if (!skipped) {
    take_camera_test(s->jobs.camera.fit, &s->camera);
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
    take_fit_result(job->skipped, s);
  } else if (std::holds_alternative<CameraJob*>(work)) {
    take_camera_result(job->skipped, s);
  } else {
    take_shape_result(*job, s);
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

/// What a map begins with is adjusted within the step, once: put off, it is tracked on while it is
/// still bent, and a body that turns by 10 deg a frame is lost before its other aspects have
/// landmarks. A start that took more frames than these is of a body that shows the same aspect for
/// longer. Its adjustments take several times as long as a step, and are done beside the steps.
bool begins_within_step(const Component::State& s) {
  constexpr std::uint32_t kKeyframesMost = 12;  // 20 to 32 take 0.1 to 0.2 s. Chosen
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
