#include "solve/bundle_adjustment.hpp"

#include <Eigen/Cholesky>

#include "solve/bundle_system.hpp"

namespace polhode {
namespace {

// Ceres's, with which the tests compare iteration by iteration: for a nearly solved problem, as a
// tracked map's is.
constexpr double kDampingFirst = 1e-4;

double try_step(double damping, BundleSystem* bundle) {
  bundle->build(damping);
  BundleSystem::Reduced S = bundle->reduced();
  const Eigen::LLT<Eigen::Ref<BundleSystem::Reduced>> factor(S);
  if (factor.info() != Eigen::Success) {
    return -1.0;
  }
  BundleSystem::Unknowns step = bundle->step();
  factor.solveInPlace(step);
  return step.allFinite() && bundle->move_poses() ? bundle->move_points(damping) : -1.0;
}

}  // namespace

BundleReport adjust_bundle(const BundleProblem& problem,
                           const BundleOptions& options,
                           BundleWorkspace* workspace) {
  BundleSystem bundle(problem, options.cauchy_sigma, workspace);
  BundleReport report = take_damped_steps(
      bundle.cost(),
      problem.observations.empty() ? 0 : options.iterations_max,
      kDampingFirst,
      [&](double damping) { return try_step(damping, &bundle); },
      [&] { return bundle.trial_cost(); },
      [&] { bundle.keep_trial(); });
  report.usable = report.usable && !problem.observations.empty();
  return report;
}

}  // namespace polhode
