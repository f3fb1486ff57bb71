#include "solve/torque_free_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"
#include "config/limits.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

// Median of chi-square with three degrees of freedom.
constexpr double kMedian3 = 2.366;
// Beyond 5 sigma a sample is taken for a wrong pose: one in a hundred thousand by chance.
constexpr double kGate2 = 25.0;
// A step that changes chi-square by less than this changes nothing that is worth having.
constexpr double kChangeMin = 1e-5;

using Squares = std::array<double, limits::kMotionPoses>;

struct System {
  TurningCovariance H = TurningCovariance::Zero();
  Eigen::Matrix<double, kTurningUnknowns, 1> g = Eigen::Matrix<double, kTurningUnknowns, 1>::Zero();
  double cost = 0.0;  ///< robust, by the scale of this solve, with the prior
  Squares squares{};  ///< chi2 of each sample by the declared noise
};

struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// One sample's part. `scale2`: variance of the noise in terms of the declared one.
void add_sample(const AttitudeSample& sample,
                const TurningState& state,
                const TurningDerivative& derivative,
                double scale2,
                double cauchy_sigma,
                double* square,
                System* system) {
  const Eigen::Vector3d r = so3_log(sample.R_IT * state.R_IT.transpose());
  const double u2 = r.dot(sample.information_I * r);
  const double c2 = cauchy_sigma * cauchy_sigma * scale2;
  const double weight = 1.0 / (scale2 * (1.0 + u2 / c2));
  const TurningMatrix WJ = sample.information_I * derivative.attitude_I;
  system->H.noalias() += weight * derivative.attitude_I.transpose() * WJ;
  system->g.noalias() += weight * WJ.transpose() * r;
  system->cost += cauchy_sigma * cauchy_sigma * std::log1p(u2 / c2);
  *square = u2;
}

/// Normal equations about `at`. False when the integration fails.
bool linearise(const TurningProblem& problem,
               const TurningSolution& at,
               const Window& window,
               double scale2,
               System* system) {
  *system = {};
  const Inertia inertia = inertia_of(at.shape);
  for (const bool forward : {true, false}) {
    TurningState state = at.reference;
    TurningDerivative derivative = TurningDerivative::at_reference();
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
  const double prior = 1.0 / (problem.shape_sigma * problem.shape_sigma);
  system->H.diagonal().tail<5>().array() += prior;
  system->g.tail<5>() -= prior * at.shape;
  system->cost += prior * at.shape.squaredNorm();
  return std::isfinite(system->cost) && system->H.allFinite();
}

double median_of(const Squares& squares, std::size_t count) {
  Squares sorted = squares;
  return median(std::span(sorted).first(count)) / kMedian3;
}

TurningSolution moved(const TurningSolution& from,
                      const Eigen::Matrix<double, kTurningUnknowns, 1>& by) {
  TurningSolution to = from;
  to.reference.R_IT = so3_exp(by.head<3>()) * from.reference.R_IT;
  to.reference.w_T_rad_s += by.segment<3>(3);
  to.shape += by.tail<5>();
  return to;
}

void describe(const System& system, std::size_t count, double scale2, TurningSolution* solution) {
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

/// Levenberg-Marquardt at a fixed noise scale.
bool minimise(const TurningProblem& problem,
              const Window& window,
              double scale2,
              int iterations_max,
              System* system,
              TurningSolution* solution) {
  if (!linearise(problem, *solution, window, scale2, system)) {
    return false;
  }
  double damping = 1e-3;
  for (int i = 0; i < iterations_max; ++i) {
    TurningCovariance H = system->H;
    H.diagonal() *= 1.0 + damping;
    const Eigen::LDLT<TurningCovariance> ldlt(H);
    const Eigen::Matrix<double, kTurningUnknowns, 1> step = ldlt.solve(system->g);
    ++solution->iterations;
    const double promised = step.dot(system->g);
    if (!step.allFinite() || !(promised > kChangeMin)) {
      return true;
    }
    const TurningSolution next = moved(*solution, step);
    System at_next;
    if (linearise(problem, next, window, scale2, &at_next) && at_next.cost < system->cost) {
      const bool done = system->cost - at_next.cost < kChangeMin;
      *solution = next;
      solution->iterations = next.iterations;
      *system = at_next;
      damping = std::max(1e-9, 0.1 * damping);
      if (done) {
        return true;
      }
    } else {
      damping = std::max(1e-4, 10.0 * damping);
      if (damping > 1e8) {
        return true;
      }
    }
  }
  return true;
}

}  // namespace

double chi2_per_dof(const TurningSolution& solution) {
  const double freedom = 3.0 * static_cast<double>(solution.inside) - kTurningUnknowns;
  return freedom > 0.0 ? solution.chi2 / freedom : 0.0;
}

Result<TurningSolution> refine_turning(const TurningProblem& problem,
                                       const TurningSolution& start,
                                       std::size_t first,
                                       std::size_t last) {
  const Window window{.first = first, .last = last};
  const std::size_t count = last - first;
  if (first > problem.reference || last <= problem.reference || last > problem.samples.size() ||
      count > limits::kMotionPoses) {
    return ErrorCode::kDegenerate;
  }
  TurningSolution solution = start;
  System system;
  if (!linearise(problem, solution, window, 1.0, &system)) {
    return ErrorCode::kDegenerate;
  }
  // The noise as found is what the loss is measured by; a start that is far off makes it wide.
  constexpr int kRounds = 3;
  double scale2 = 1.0;
  for (int round = 0; round < kRounds; ++round) {
    const double found = std::max(1e-2, median_of(system.squares, count));
    if (round > 0 && std::abs(found - scale2) < 0.1 * scale2) {
      break;
    }
    scale2 = found;
    if (!minimise(problem, window, scale2, problem.iterations_max, &system, &solution)) {
      return ErrorCode::kDegenerate;
    }
  }
  describe(system, count, scale2, &solution);
  // The information is that of the declared noise: prior and data part as they were declared.
  const double prior = 1.0 / (problem.shape_sigma * problem.shape_sigma);
  solution.information.diagonal().tail<5>().array() -= prior;
  solution.information *= scale2;
  solution.information.diagonal().tail<5>().array() += prior;
  return solution;
}

}  // namespace polhode
