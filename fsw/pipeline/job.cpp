#include "pipeline/job.hpp"

#include <initializer_list>

#include "base/assert.hpp"

namespace polhode {
namespace {

/// Runs, or skips without a result, each kind of work.
struct Run {
  void operator()(std::monostate) const {}
  void operator()(InitialisationJob* work) const { run_initialisation(work); }
  void operator()(AdjustmentJob* work) const { run_adjustment(work); }
  void operator()(FitJob* work) const { run_fit(work); }
  void operator()(ShapeJob* work) const { run_shape(work); }
  void operator()(CameraJob* work) const { run_camera_test(work); }
};

struct Skip {
  void operator()(InitialisationJob* work) const { skip_initialisation(work); }
  void operator()(AdjustmentJob* work) const { skip_adjustment(work); }
  template <typename Other>
  void operator()(Other /*work*/) const {}  // it has no result until it is run
};

}  // namespace

void run_job(Job& job) {
  std::visit(Run{}, job.work);
  job.done = true;
}

void skip_job(Job& job) {
  std::visit(Skip{}, job.work);
  job.skipped = true;
  job.done = true;
}

std::uint32_t due_step(const Job& job) { return job.due_step; }

void issue_job(JobWork work, const JobTimes& times, Job* job, JobQueue* queue) {
  POLHODE_ASSERT(!is_out(*job), job->due_step);
  *job = {.work = work, .due_step = times.step + times.delay};
  ++queue->counts.issued;
}

void invalidate_fits(JobQueue* queue) {
  queue->fit.unwanted = true;
  queue->adjustment.model_unwanted = true;
}

void invalidate_start(JobQueue* queue) {
  queue->map.unwanted = queue->map.unwanted || is_out_with<InitialisationJob>(queue->map);
}

void invalidate_all(JobQueue* queue) {
  for (Job* const job : {&queue->map, &queue->fit, &queue->shape}) {
    job->unwanted = true;
  }
  queue->adjustment.model_unwanted = true;
}

Jobs hand_out(JobQueue* queue) {
  Jobs jobs;
  for (Job* const job : {&queue->map, &queue->fit, &queue->shape}) {
    if (is_out(*job) && !job->handed_out) {
      job->handed_out = true;
      (void)jobs.push_back(job);
    }
  }
  return jobs;
}

}  // namespace polhode
