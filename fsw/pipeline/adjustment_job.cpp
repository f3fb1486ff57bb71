#include "pipeline/adjustment_job.hpp"

namespace polhode {

void run_adjustment(AdjustmentJob* job) {
  job->usable = false;
  for (const BundleOptions& round : job->rounds) {
    job->usable = adjust(&job->snapshot, round).usable || job->usable;
  }
  const RigidModel previous = job->model;
  job->model = {};
  // On thirty runs of fifteen rendered scenes attitudes are off by 1.4 times what observations that
  // nobody chose would allow.
  constexpr double kChosenByPoses = 2.0;
  if (job->as_free_body && job->usable) {
    job->model = fit_jointly({.bundle = problem_of(&job->snapshot),
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
}

void skip_adjustment(AdjustmentJob* job) {
  job->usable = false;
  job->model = {};
}

}  // namespace polhode
