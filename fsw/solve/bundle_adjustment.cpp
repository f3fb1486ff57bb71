#include "solve/bundle_adjustment.hpp"

#include <Eigen/Cholesky>

#include "solve/bundle_system.hpp"

namespace polhode {
namespace {

double try_step(double damping, BundleSystem* system) {
  system->build(damping);
  BundleSystem::Reduced S = system->reduced();
  const Eigen::LLT<Eigen::Ref<BundleSystem::Reduced>> factor(S);
  if (factor.info() != Eigen::Success) {
    return -1.0;
  }
  BundleSystem::Unknowns step = system->step();
  factor.solveInPlace(step);
  return step.allFinite() && system->move_poses() ? system->move_points(damping) : -1.0;
}

}  // namespace

BundleReport adjust_bundle(const BundleProblem& problem,
                           const BundleOptions& options,
                           BundleWorkspace* workspace) {
  BundleSystem system(problem, options.cauchy_sigma, workspace);
  BundleReport report = take_damped_steps(
      system.cost(),
      problem.observations.empty() ? 0 : options.iterations_max,
      [&](double damping) { return try_step(damping, &system); },
      [&] { return system.trial_cost(); },
      [&] { system.keep_trial(); });
  report.usable = report.usable && !problem.observations.empty();
  return report;
}

}  // namespace polhode
