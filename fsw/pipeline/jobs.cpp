#include "pipeline/jobs.hpp"

#include "base/assert.hpp"
#include "pipeline/begin.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

// A start is followed by two adjustments, each of which ends before the next begins.
constexpr int kJobsInARowMax = 4;

void run_start(StartJob* job) {
  job->outcome = run_start_contest({.times_s = std::span(job->times_s).first(job->frame_count),
                                    .tracks = std::span(job->tracks).first(job->track_count),
                                    .seed = job->seed},
                                   job->options,
                                   job->workspace);
}

void run_adjustment(AdjustmentJob* job) {
  job->usable = false;
  for (const BundleOptions& round : job->rounds) {
    job->usable = adjust(&job->snapshot, round, &job->workspace).usable || job->usable;
  }
}

void take_result(Component::State* s) {
  const JobKind kind = s->job.kind;
  POLHODE_ASSERT(s->job.done, s->job.due_step);
  s->job.kind = JobKind::kNone;
  s->counters.jobs_without_result += s->job.skipped ? 1 : 0;
  if (kind == JobKind::kStart) {
    take_start(s);
  } else if (kind == JobKind::kAdjustment) {
    take_adjustment(s);
  }
  stage_done(Stage::kJobs, *s);
}

}  // namespace

void run_job(Job& job) {
  if (job.kind == JobKind::kStart) {
    run_start(&job.start);
  } else if (job.kind == JobKind::kAdjustment) {
    run_adjustment(&job.adjustment);
  }
  job.done = true;
}

void skip_job(Job& job) {
  job.start.outcome.decision = StartDecision::kTooFewTracks;
  job.adjustment.usable = false;
  job.skipped = true;
  job.done = true;
}

std::uint32_t due_step(const Job& job) { return job.due_step; }

void issue_job(JobKind kind, Component::State* s) {
  POLHODE_ASSERT(job_slot_free(*s), s->job.due_step);
  s->job.kind = kind;
  s->job.done = false;
  s->job.skipped = false;
  s->job.issued_step = s->frame;
  s->job.due_step = s->frame + static_cast<std::uint32_t>(s->parameters.jobs.delay_frames);
  ++s->counters.jobs_issued;
}

bool job_slot_free(const Component::State& s) { return s.job.kind == JobKind::kNone; }

void take_due_job(Job* finished, Component::State* s) {
  if (job_slot_free(*s) || s->frame < s->job.due_step) {
    POLHODE_ASSERT(finished == nullptr, s->frame);
    return;
  }
  // The caller waits for a late job before it steps: without that, results would depend on time.
  POLHODE_ASSERT(finished == &s->job, s->frame);
  take_result(s);
}

void run_undelayed_jobs(Component::State* s) {
  if (s->parameters.jobs.delay_frames == 0) {
    close_jobs(s);
  }
}

void close_jobs(Component::State* s) {
  for (int i = 0; i < kJobsInARowMax && !job_slot_free(*s); ++i) {
    if (!s->job.done) {
      run_job(s->job);
    }
    take_result(s);
  }
  POLHODE_ASSERT(job_slot_free(*s), s->job.due_step);
}

Job* job_for_caller(Component::State* s) {
  return !job_slot_free(*s) && s->job.issued_step == s->frame ? &s->job : nullptr;
}

}  // namespace polhode
