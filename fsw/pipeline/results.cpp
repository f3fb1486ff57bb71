#include "pipeline/results.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "pipeline/begin.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/motion_jobs.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/shape_now.hpp"

namespace polhode {
namespace {

// A start is followed by two adjustments, each of which ends before the next begins.
constexpr int kJobsInARowMax = 4;

void take_result(Job* job, Component::State* s) {
  const JobKind kind = job->kind;
  POLHODE_ASSERT(job->done, job->due_step);
  job->kind = JobKind::kNone;
  s->counters.jobs_without_result += job->skipped ? 1 : 0;
  if (job->unwanted) {
    return;
  }
  if (kind == JobKind::kStart) {
    take_start(s);
  } else if (kind == JobKind::kAdjustment) {
    take_adjustment(s);
  } else if (kind == JobKind::kFit) {
    take_fit_job(s);
  } else if (kind == JobKind::kShape) {
    take_shape(s);
  }
  stage_done(Stage::kJobs, *s);
}

void take_if_due(Job* job, const Jobs& finished, Component::State* s) {
  const bool handed_in = std::find(finished.begin(), finished.end(), job) != finished.end();
  const bool due = job->kind != JobKind::kNone && s->frame >= job->due_step;
  // The caller waits for a late job before it steps: without that, results would depend on time.
  POLHODE_ASSERT(handed_in == due, s->frame);
  if (due) {
    take_result(job, s);
  }
}

void close(Job* job, Component::State* s) {
  for (int i = 0; i < kJobsInARowMax && job->kind != JobKind::kNone; ++i) {
    if (!job->done) {
      run_job(*job);
    }
    take_result(job, s);
  }
  POLHODE_ASSERT(job->kind == JobKind::kNone, job->due_step);
}

}  // namespace

void take_due_jobs(const Jobs& finished, Component::State* s) {
  take_if_due(&s->job, finished, s);
  take_if_due(&s->fit_job, finished, s);
  take_if_due(&s->shape_job, finished, s);
  // What a map begins with is adjusted within the step, once: put off, it is tracked on while it is
  // still bent, and a body that turns by 10 deg a frame is lost before its other sides have
  // landmarks.
  const bool begins = s->job.kind == JobKind::kAdjustment &&
                      s->job.adjustment.reason != AdjustmentReason::kMapGrown;
  if (begins) {
    close(&s->job, s);
  }
}

void run_undelayed(Job* job, Component::State* s) {
  if (s->parameters.jobs.delay_frames == 0) {
    close(job, s);
  }
}

void close_jobs(Component::State* s) {
  close(&s->job, s);
  close(&s->fit_job, s);
  close(&s->shape_job, s);
}

}  // namespace polhode
