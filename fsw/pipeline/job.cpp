#include "pipeline/work.hpp"

namespace polhode {
namespace {

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

}  // namespace

void run_adjustment(AdjustmentJob* job) {
  job->usable = false;
  for (const BundleOptions& round : job->rounds) {
    job->usable = adjust(&job->snapshot, round, &job->workspace).usable || job->usable;
  }
  const RigidModel previous = job->model;
  job->model = {};
  // On thirty runs of fifteen rendered scenes attitudes are off by 1.4 times what sightings that
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
                             &job->doubts,
                             &job->workspace,
                             &job->joint);
  }
}

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

}  // namespace polhode
