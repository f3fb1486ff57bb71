#include "solve/mass_centre_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"
#include "config/limits.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

// Least samples: twelve coordinates for nine unknowns.
constexpr std::size_t kSamplesMin = 4;
// Rounds: the first has equal weights, each later one the weights by the last residuals. Chosen.
constexpr int kRounds = 4;
// Least ratio of found to declared variance, so that exact data divide by no zero. A hundredth of
// the sigma.
constexpr double kScale2Min = 1e-4;

using Squares = std::array<double, limits::kMotionPoses>;
using PathRows = Eigen::Matrix<double, 3, kTranslationUnknowns>;

PathRows rows_of(const TranslationProblem& problem, const PositionSample& sample) {
  const Eigen::Matrix<double, 6, 6> transition = translation_transition(
      problem.orbit, problem.reference_s, sample.time_s - problem.reference_s);
  PathRows rows;
  rows << transition.topRows<3>(), -sample.R_IT;
  return rows;
}

double scale_of(const Squares& squares, std::size_t count) {
  Squares sorted = squares;
  return median(std::span(sorted).first(count)) / kChi2Median3;
}

struct System {
  TranslationCovariance H = TranslationCovariance::Zero();
  TranslationVector g = TranslationVector::Zero();
  Eigen::Matrix<double, kTranslationUnknowns, kRotationUnknowns> by_rotation =
      Eigen::Matrix<double, kTranslationUnknowns, kRotationUnknowns>::Zero();
};

/// Normal equations with Cauchy weights by `squares` (nullptr: equal weights).
System accumulate(const TranslationProblem& problem,
                  const Squares* squares,
                  double scale2,
                  const Eigen::Vector3d& offset_T) {
  System system;
  const double c2 = problem.cauchy_sigma * problem.cauchy_sigma * scale2;
  for (std::size_t i = 0; i < problem.samples.size(); ++i) {
    const PositionSample& sample = problem.samples[i];
    const double weight = squares == nullptr ? 1.0 : 1.0 / (1.0 + (*squares)[i] / c2);
    const PathRows rows = rows_of(problem, sample);
    const PathRows weighted = weight * sample.information_I * rows;
    system.H.noalias() += rows.transpose() * weighted;
    system.g.noalias() += weighted.transpose() * sample.p_I;
    // An attitude error phi moves the offset R c by phi x R c.
    const Eigen::Matrix3d by_phi = hat(sample.R_IT * offset_T);
    system.by_rotation.noalias() -= weighted.transpose() * (by_phi * sample.attitude_by_rotation_I);
  }
  return system;
}

}  // namespace

Eigen::Matrix<double, 6, 6> translation_transition(const Orbit& orbit,
                                                   double time_s,
                                                   double interval_s) {
  Eigen::Matrix<double, 6, 6> transition = Eigen::Matrix<double, 6, 6>::Identity();
  if (!orbit.active()) {
    transition.topRightCorner<3, 3>() = interval_s * Eigen::Matrix3d::Identity();
    return transition;
  }
  const double n = orbit.mean_motion_rad_s;
  const double t = interval_s;
  const double s = std::sin(n * t);
  const double c = std::cos(n * t);
  Eigen::Matrix<double, 6, 6> hill;  // Clohessy and Wiltshire, in the rotating axes of H
  hill << 4.0 - 3.0 * c, 0.0, 0.0, s / n, 2.0 / n * (1.0 - c), 0.0,                         //
      6.0 * (s - n * t), 1.0, 0.0, -2.0 / n * (1.0 - c), (4.0 * s - 3.0 * n * t) / n, 0.0,  //
      0.0, 0.0, c, 0.0, 0.0, s / n,                                                         //
      3.0 * n * s, 0.0, 0.0, c, 2.0 * s, 0.0,                                               //
      -6.0 * n * (1.0 - c), 0.0, 0.0, -2.0 * s, 4.0 * c - 3.0, 0.0,                         //
      0.0, 0.0, -n * s, 0.0, 0.0, c;
  const Eigen::Matrix3d rotation = hat({0.0, 0.0, n});
  const auto to_hill = [&](const Eigen::Matrix3d& R_HI) {
    Eigen::Matrix<double, 6, 6> to = Eigen::Matrix<double, 6, 6>::Zero();
    to.topLeftCorner<3, 3>() = R_HI;
    to.bottomRightCorner<3, 3>() = R_HI;
    to.bottomLeftCorner<3, 3>() = -rotation * R_HI;
    return to;
  };
  const Eigen::Matrix3d R_IH = orbit.R_IH_at(time_s + interval_s);
  Eigen::Matrix<double, 6, 6> from_hill = Eigen::Matrix<double, 6, 6>::Zero();
  from_hill.topLeftCorner<3, 3>() = R_IH;
  from_hill.bottomRightCorner<3, 3>() = R_IH;
  from_hill.bottomLeftCorner<3, 3>() = R_IH * rotation;
  return from_hill * hill * to_hill(orbit.R_IH_at(time_s).transpose());
}

Result<TranslationSolution> solve_translation(const TranslationProblem& problem) {
  const std::size_t count = problem.samples.size();
  if (count < kSamplesMin) {
    return ErrorCode::kTooFewObservations;
  }
  if (!(problem.mass_centre_sigma.minCoeff() > 0.0) || !problem.mass_centre_sigma.allFinite()) {
    return ErrorCode::kBadParameter;
  }
  if (count > limits::kMotionPoses ||
      !(problem.samples.back().time_s > problem.samples.front().time_s)) {
    return ErrorCode::kDegenerate;
  }
  const Eigen::Vector3d prior = problem.mass_centre_sigma.cwiseAbs2().cwiseInverse();
  TranslationSolution solution;
  Squares squares{};
  System system;
  for (int round = 0; round < kRounds; ++round) {
    const double scale2 = round == 0 ? 1.0 : std::max(kScale2Min, scale_of(squares, count));
    system =
        accumulate(problem, round == 0 ? nullptr : &squares, scale2, solution.unknowns.tail<3>());
    // The data are scaled to the noise as found; the prior keeps its own sigma.
    TranslationCovariance H = system.H / scale2;
    H.diagonal().tail<3>() += prior;
    TranslationVector g = system.g / scale2;
    g.tail<3>() += prior.cwiseProduct(problem.mass_centre_T);
    solution.unknowns = H.ldlt().solve(g);
    if (!solution.unknowns.allFinite()) {
      return ErrorCode::kDegenerate;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const PositionSample& sample = problem.samples[i];
      const Eigen::Vector3d r = sample.p_I - rows_of(problem, sample) * solution.unknowns;
      squares[i] = r.dot(sample.information_I * r);
    }
  }
  solution.information = system.H;
  solution.information.diagonal().tail<3>() += prior;
  solution.by_rotation = solution.information.ldlt().solve(system.by_rotation);
  return solution;
}

}  // namespace polhode
