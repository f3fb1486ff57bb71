#include "pipeline/jobs.hpp"

#include <initializer_list>

#include "base/assert.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

void issue(JobKind kind, Job* job, Component::State* s) {
  POLHODE_ASSERT(job->kind == JobKind::kNone, job->due_step);
  *job = {.kind = kind,
          .issued_step = s->frame,
          .due_step = s->frame + static_cast<std::uint32_t>(s->parameters.jobs.delay_frames)};
  ++s->counters.jobs_issued;
}

}  // namespace

void issue_job(JobKind kind, Component::State* s) { issue(kind, &s->job, s); }

void issue_fit(Component::State* s) { issue(JobKind::kFit, &s->fit_job, s); }

void issue_shape(Component::State* s) { issue(JobKind::kShape, &s->shape_job, s); }

bool job_slot_free(const Component::State& s) { return s.job.kind == JobKind::kNone; }
bool fit_slot_free(const Component::State& s) { return s.fit_job.kind == JobKind::kNone; }
bool shape_slot_free(const Component::State& s) { return s.shape_job.kind == JobKind::kNone; }

void give_up_start(Component::State* s) {
  s->job.unwanted = s->job.unwanted || s->job.kind == JobKind::kStart;
}

void forget_jobs(Component::State* s) {
  s->job.unwanted = true;
  s->fit_job.unwanted = true;
  s->shape_job.unwanted = true;
  s->growth = {};
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
