// The long work of a component: plain snapshots that pure functions turn into results, on whichever
// thread the caller likes.
//
// One job of the map, one fit of the dynamics and one estimate of the shape, or test of the
// camera, are out at a time; none waits for another, as the others change nothing of the map. A
// result is taken in at a step that is named when the job is issued (logical execution time), so
// the packets do not depend on how long the work took.
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

/// What is to be done; nothing while the job is not out.
using JobWork = std::
    variant<std::monostate, InitialisationJob*, AdjustmentJob*, FitJob*, ShapeJob*, CameraJob*>;

struct Job {
  JobWork work;
  bool done = false;
  bool skipped = false;   ///< there is no result
  bool unwanted = false;  ///< the result is for nothing: what it was taken from is no longer there
  bool handed_out = false;  ///< to the caller, with the output of the step that issued it
  std::uint32_t due_step = 0;
};

[[nodiscard]] inline bool is_out(const Job& job) { return job.work.index() != 0; }

/// Is work of this kind out?
template <typename Work>
[[nodiscard]] bool is_out_with(const Job& job) {
  return std::holds_alternative<Work*>(job.work);
}

/// Since they were last taken.
struct JobCounts {
  std::uint32_t issued = 0;
  std::uint32_t tables_full = 0;
};

/// The state of this room: what is out, and the tables that it works on.
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

/// Sends off what has been prepared: to the caller with this step's output, or, with a delay of 0,
/// to be run within the step.
/// @param job  one of the queue's, not out.
void issue_job(JobWork work, const JobTimes& times, Job* job, JobQueue* queue);

/// What is being fitted to the poses so far is for nothing.
void invalidate_fits(JobQueue* queue);

/// A hypothesis selection that is out is for frames that are no longer there.
void invalidate_start(JobQueue* queue);

/// What is out belongs to a target that is forgotten.
void invalidate_all(JobQueue* queue);

/// The jobs issued in this step, for the caller to run; each is handed out once.
[[nodiscard]] Jobs hand_out(JobQueue* queue);

}  // namespace polhode
