#include "pipeline/jobs.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "pipeline/begin.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/motion_jobs.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

// A start is followed by two adjustments, each of which ends before the next begins.
constexpr int kJobsInARowMax = 4;

void run_fit(FitJob* job) { job->model = fit_rigid_model(job->snapshot, job->workspace); }

void run_shape(ShapeJob* job) {
  const Result<Shape> shape = estimate_shape(job->landmarks_T.view(),
                                             job->options,
                                             job->seed,
                                             job->previous ? &*job->previous : nullptr,
                                             job->work);
  if (shape) {
    job->outcome = shape.value();
  }
}

void issue(JobKind kind, Job* job, Component::State* s) {
  POLHODE_ASSERT(job->kind == JobKind::kNone, job->due_step);
  *job = {.kind = kind,
          .issued_step = s->frame,
          .due_step = s->frame + static_cast<std::uint32_t>(s->parameters.jobs.delay_frames)};
  ++s->counters.jobs_issued;
}

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

void run_job(Job& job) {
  if (job.kind == JobKind::kStart) {
    run_start(&static_cast<MapJob&>(job).start);
  } else if (job.kind == JobKind::kAdjustment) {
    run_adjustment(&static_cast<MapJob&>(job).adjustment);
  } else if (job.kind == JobKind::kFit) {
    run_fit(&static_cast<FitJob&>(job));
  } else if (job.kind == JobKind::kShape) {
    run_shape(&static_cast<ShapeJob&>(job));
  }
  job.done = true;
}

void skip_job(Job& job) {
  if (job.kind == JobKind::kStart) {
    skip_start(&static_cast<MapJob&>(job).start);
  } else if (job.kind == JobKind::kAdjustment) {
    static_cast<MapJob&>(job).adjustment.usable = false;
    static_cast<MapJob&>(job).adjustment.model = {};
  }
  job.skipped = true;
  job.done = true;
}

std::uint32_t due_step(const Job& job) { return job.due_step; }

void issue_job(JobKind kind, Component::State* s) { issue(kind, &s->job, s); }

void issue_fit(Component::State* s) {
  issue(JobKind::kFit, &s->fit_job, s);
  if (s->parameters.jobs.delay_frames == 0) {
    close(&s->fit_job, s);
  }
}

void issue_shape(Component::State* s) {
  issue(JobKind::kShape, &s->shape_job, s);
  if (s->parameters.jobs.delay_frames == 0) {
    close(&s->shape_job, s);
  }
}

bool job_slot_free(const Component::State& s) { return s.job.kind == JobKind::kNone; }
bool fit_slot_free(const Component::State& s) { return s.fit_job.kind == JobKind::kNone; }
bool shape_slot_free(const Component::State& s) { return s.shape_job.kind == JobKind::kNone; }

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

void give_up_start(Component::State* s) {
  s->job.unwanted = s->job.unwanted || s->job.kind == JobKind::kStart;
}

void forget_jobs(Component::State* s) {
  s->job.unwanted = true;
  s->fit_job.unwanted = true;
  s->shape_job.unwanted = true;
  s->growth = {};
}

void run_undelayed_jobs(Component::State* s) {
  if (s->parameters.jobs.delay_frames == 0) {
    close(&s->job, s);
  }
}

void close_jobs(Component::State* s) {
  close(&s->job, s);
  close(&s->fit_job, s);
  close(&s->shape_job, s);
}

Jobs jobs_for_caller(Component::State* s) {
  Jobs jobs;
  for (Job* const job : std::initializer_list<Job*>{&s->job, &s->fit_job, &s->shape_job}) {
    if (job->kind != JobKind::kNone && job->issued_step == s->frame) {
      (void)jobs.push_back(job);
    }
  }
  return jobs;
}

}  // namespace polhode
