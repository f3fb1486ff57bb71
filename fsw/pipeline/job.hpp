// The long work of a component: pure functions turn plain snapshots into results, on any thread of
// the caller.
//
// One job of the map, one fit of the dynamics and one estimate of the shape, or test of the camera,
// are out at a time. None waits for another, as only the first changes the map. The step that takes
// a result is fixed when the job is issued (logical execution time), so the packets do not depend
// on how long the work took.
#pragma once

#include <cstdint>
#include <variant>

#include "initialisation/initialisation_job.hpp"
#include "motion/fit_job.hpp"
#include "pipeline/adjustment_job.hpp"
#include "pipeline/camera_job.hpp"
#include "pipeline/component.hpp"
#include "pipeline/job_times.hpp"
#include "shape/shape_job.hpp"

namespace polhode {

/// The job's data; empty while the job is not out.
using JobWork = std::
    variant<std::monostate, InitialisationJob*, AdjustmentJob*, FitJob*, ShapeJob*, CameraJob*>;

struct Job {
  JobWork work;
  bool done = false;
  bool skipped = false;     ///< there is no result
  bool unwanted = false;    ///< stale: the data it was prepared from has been reset
  bool handed_out = false;  ///< to the caller, with the output of the step that issued it
  std::uint32_t due_step = 0;
};

[[nodiscard]] inline bool is_out(const Job& job) { return job.work.index() != 0; }

/// Is work of this kind out?
template <typename Work>
[[nodiscard]] bool is_out_with(const Job& job) {
  return std::holds_alternative<Work*>(job.work);
}

/// Counts since take_counts().
struct JobCounts {
  std::uint32_t issued = 0;
  std::uint32_t tables_full = 0;
};

/// The state of this room: jobs that are out, and their tables.
struct JobQueue {
  Job map;  ///< an initialisation or an adjustment
  Job fit;
  Job shape;  ///< an estimate of the shape, or a test of the camera
  JobCounts counts;
  InitialisationJob start;
  AdjustmentJob adjustment;
  FitJob fit_work;
  ShapeJob shape_work;
  CameraJob camera;
};

/// Issues a prepared job: to the caller with this step's output, or, with a delay of 0, to run
/// within the step.
/// @param job  one of the queue's jobs, which holds no work.
void issue_job(JobWork work, const JobTimes& times, Job* job, JobQueue* queue);

/// Marks fits to the poses so far as stale.
void invalidate_fits(JobQueue* queue);

/// Marks a hypothesis selection that is out as stale: its frames have been reset.
void invalidate_start(JobQueue* queue);

/// Marks all jobs that are out as stale: their target has been reset.
void invalidate_all(JobQueue* queue);

/// The jobs issued in this step, for the caller to run; each is handed out once.
[[nodiscard]] Jobs hand_out(JobQueue* queue);

}  // namespace polhode
