#include "solve/ceres_solver.hpp"

#include <glog/logging.h>

#include <cmath>

namespace polhode {

ceres::Problem::Options problem_options(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options options;
  options.evaluation_callback = callback;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  // Ceres's safety checks compare addresses of blocks, which takes as long as a step. Our blocks
  // are added in one place, with fixed types.
  options.disable_all_safety_checks = true;
  return options;
}

ceres::Solver::Options solver_options(int iterations_max) {
  // Its messages would go to the standard error and to files; the summary has the same content.
  FLAGS_minloglevel = google::GLOG_FATAL;
  ceres::Solver::Options options;
  options.max_num_iterations = iterations_max;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  options.dense_linear_algebra_library_type = ceres::EIGEN;  // LAPACK may use threads
  // Damping relative to each unknown's curvature, unscaled.
  options.jacobi_scaling = false;
  // Ceres's default. From 1e4 to 1e10 adjustments took the same steps (decision 0041).
  options.initial_trust_region_radius = 1e4;
  // Relative gain. Small, because weak directions settle last (decision 0041).
  options.function_tolerance = 5e-5;
  // Only the gain ends an adjustment: the size of a gradient or a step depends on the map's unit.
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  // Beyond this damping, 1e12, steps are too small to matter.
  options.min_trust_region_radius = 1e-12;
  return options;
}

BundleReport report_of(const ceres::Solver::Summary& summary) {
  const bool usable = summary.IsSolutionUsable() && std::isfinite(summary.final_cost);
  return {.usable = usable,
          .iterations = static_cast<int>(summary.iterations.size()) - 1,
          .cost_before = summary.initial_cost,
          .cost_after = usable ? summary.final_cost : summary.initial_cost};
}

}  // namespace polhode
