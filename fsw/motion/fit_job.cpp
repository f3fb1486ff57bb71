#include "motion/fit_job.hpp"

namespace polhode {

void prepare_fit(const Map& map,
                 const MapDrift& drift,
                 const MotionOptions& options,
                 MotionEstimate* motion,
                 FitJob* job) {
  prepare_fit(map, drift, options, motion, &job->snapshot);
  job->poses_new = motion->poses_since_fit;
}

void run_fit(FitJob* job) { job->model = fit_rigid_model(job->snapshot, job->workspace); }

}  // namespace polhode
