#include "solve/torque_free_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"
#include "config/limits.hpp"
#include "geometry/so3.hpp"
#include "solve/small_fit.hpp"

namespace polhode {
namespace {

// 5 sigma, beyond which a sample counts as a wrong pose: 1.5e-5 of normal errors are (chi-square,
// three degrees of freedom).
constexpr double kGate2 = 25.0;
using Squares = std::array<double, limits::kMotionPoses>;

/// The cost is robust, by the scale of this solve, with the prior.
struct System : SmallEquations<kRotationUnknowns> {
  Squares squares{};  ///< chi2 of each sample by the declared noise
};

struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Adds one sample. `scale2`: variance of the noise over the declared one.
void add_sample(const AttitudeSample& sample,
                const RotationState& state,
                const RotationDerivative& derivative,
                double scale2,
                double cauchy_sigma,
                double* square,
                System* system) {
  const Eigen::Vector3d r = -so3_log(sample.R_IT * state.R_IT.transpose());
  const double u2 = r.dot(sample.information_I * r);
  const double c2 = cauchy_sigma * cauchy_sigma * scale2;
  const double weight = 1.0 / (scale2 * (1.0 + u2 / c2));
  const RotationJacobian WJ = sample.information_I * derivative.attitude_I;
  system->H.noalias() += weight * derivative.attitude_I.transpose() * WJ;
  system->g.noalias() += weight * WJ.transpose() * r;
  system->cost += cauchy_sigma * cauchy_sigma * std::log1p(u2 / c2);
  *square = u2;
}

/// Normal equations about `at`. False when the integration fails.
bool linearise(const RotationProblem& problem,
               const RotationSolution& at,
               const Window& window,
               double scale2,
               System* system) {
  *system = {};
  const Inertia inertia = inertia_of(at.shape);
  for (const bool forward : {true, false}) {
    RotationState state = at.reference;
    RotationDerivative derivative = RotationDerivative::at_reference();
    const std::size_t count =
        forward ? window.last - problem.reference : problem.reference - window.first;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = forward ? problem.reference + k : problem.reference - 1 - k;
      const AttitudeSample& sample = problem.samples[i];
      if (!advance(inertia, problem.orbit, sample.time_s, state, &derivative)) {
        return false;
      }
      add_sample(sample,
                 state,
                 derivative,
                 scale2,
                 problem.cauchy_sigma,
                 &system->squares[i - window.first],
                 system);
    }
  }
  const InertiaShape prior = problem.prior.information();
  const InertiaShape off = at.shape - problem.prior.mean;
  system->H.diagonal().tail<5>() += prior;
  system->g.tail<5>() += prior.cwiseProduct(off);
  system->cost += prior.dot(off.cwiseAbs2());
  return std::isfinite(system->cost) && system->H.allFinite();
}

double median_of(const Squares& squares, std::size_t count) {
  Squares sorted = squares;
  return median(std::span(sorted).first(count)) / kChi2Median3;
}

RotationSolution moved(const RotationSolution& from, const System::Vector& by) {
  RotationSolution to = from;
  to.reference.R_IT = so3_exp(by.head<3>()) * from.reference.R_IT;
  to.reference.w_T_rad_s += by.segment<3>(3);
  to.shape += by.tail<5>();
  return to;
}

void fill_statistics(const System& system,
                     std::size_t count,
                     double scale2,
                     RotationSolution* solution) {
  solution->information = system.H;
  solution->median2 = median_of(system.squares, count);
  solution->cost = 0.0;
  solution->chi2 = 0.0;
  solution->inside = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double u2 = system.squares[i];
    solution->cost += std::log1p(u2);
    if (u2 <= kGate2 * std::max(1.0, scale2)) {
      solution->chi2 += u2;
      ++solution->inside;
    }
  }
}

/// At a fixed noise scale. False when the integration fails at the start.
bool minimise_at(const RotationProblem& problem,
                 const Window& window,
                 double scale2,
                 System* system,
                 RotationSolution* solution) {
  const RotationSolution start = *solution;
  System::Vector by = System::Vector::Zero();
  const int steps = minimise(
      [&](const System::Vector& by_trial, System* at) {
        return linearise(problem, moved(start, by_trial), window, scale2, at);
      },
      {.steps_max = problem.iterations_max, .first_three = FirstThree::kRotation},
      &by,
      system);
  *solution = moved(start, by);
  solution->iterations += std::max(0, steps);
  return steps >= 0;
}

}  // namespace

double chi2_per_dof(const RotationSolution& solution) {
  const double freedom = 3.0 * static_cast<double>(solution.inside) - kRotationUnknowns;
  return freedom > 0.0 ? solution.chi2 / freedom : 0.0;
}

Result<RotationSolution> refine_rotation(const RotationProblem& problem,
                                         const RotationSolution& start,
                                         std::size_t first,
                                         std::size_t last) {
  const Window window{.first = first, .last = last};
  const std::size_t count = last - first;
  if (first > problem.reference || last <= problem.reference || last > problem.samples.size() ||
      count > limits::kMotionPoses) {
    return ErrorCode::kDegenerate;
  }
  RotationSolution solution = start;
  System system;
  if (!linearise(problem, solution, window, 1.0, &system)) {
    return ErrorCode::kDegenerate;
  }
  // The width of the loss follows the noise as found: wide when the first solution is far off.
  constexpr int kRounds = 3;
  // Least variance found over declared: a tenth of the sigma.
  constexpr double kScale2Min = 1e-2;
  // Relative change of the variance that changes no weight worth another round. Chosen.
  constexpr double kScaleSettled = 0.1;
  double scale2 = 1.0;
  for (int round = 0; round < kRounds; ++round) {
    const double found = std::max(kScale2Min, median_of(system.squares, count));
    if (round > 0 && std::abs(found - scale2) < kScaleSettled * scale2) {
      break;
    }
    scale2 = found;
    if (!minimise_at(problem, window, scale2, &system, &solution)) {
      return ErrorCode::kDegenerate;
    }
  }
  fill_statistics(system, count, scale2, &solution);
  // Back to the declared noise: the data's part is scaled, the prior's is not.
  const InertiaShape prior = problem.prior.information();
  solution.information.diagonal().tail<5>() -= prior;
  solution.information *= scale2;
  solution.information.diagonal().tail<5>() += prior;
  return solution;
}

}  // namespace polhode
