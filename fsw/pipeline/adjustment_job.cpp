#include "pipeline/adjustment_job.hpp"

#include <utility>

#include "map/validity.hpp"

namespace polhode {

namespace {

RigidModel fit_as_free_body(const RigidModel& previous, AdjustmentJob* job) {
  // On thirty runs of fifteen rendered scenes attitude errors are 1.4 times those that unselected
  // observations would give.
  constexpr double kChosenByPoses = 2.0;
  return fit_jointly({.bundle = problem_of(&job->snapshot),
                      .observations = job->snapshot.observations.view(),
                      .timestamps_ns = job->snapshot.timestamps_ns.view(),
                      .R_IC = job->snapshot.R_IC.view(),
                      .body_radius = job->body_radius_mu,
                      .motion = job->motion,
                      .previous = previous,
                      .options = job->rounds.back(),
                      .selection = kChosenByPoses},
                     &job->marginal_fits,
                     &job->joint);
}

}  // namespace

void run_adjustment(AdjustmentJob* job) {
  if (!is_valid(job->snapshot)) {  // damaged in memory while it waited
    skip_adjustment(job);
    return;
  }
  const RigidModel previous = std::exchange(job->model, RigidModel{});
  // Poses that follow a motion already need no free adjustment before the next joint fit.
  if (job->as_free_body && !job->closed && previous.accepted() && previous.of_map) {
    job->model = fit_as_free_body(previous, job);
    job->usable = job->model.accepted();
    if (job->usable) {
      return;
    }
  }
  job->usable = false;
  for (const BundleOptions& round : job->rounds) {
    job->usable = adjust(&job->snapshot, round).usable || job->usable;
  }
  if (job->as_free_body && job->usable) {
    job->model = fit_as_free_body(previous, job);
  }
}

void skip_adjustment(AdjustmentJob* job) {
  job->usable = false;
  job->model = {};
}

}  // namespace polhode
