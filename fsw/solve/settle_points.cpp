#include "solve/settle_points.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "base/avx2_dispatch.hpp"
#include "base/index.hpp"

namespace polhode {
namespace {

// Least diagonal element for the damping, as a part of the largest: a weaker unknown has no
// information of its own, and the damping must still constrain it. Far above rounding.
constexpr double kDiagonalMin = 1e-12;

// Damping of a point's own steps, for points with next to no parallax.
constexpr double kSettlingDamping = 1e-6;

/// @return half the robust sum of squares.
double settled(std::span<const BundleObservation> observations,
               std::span<const InverseDepthPose> poses,
               double cauchy_sigma,
               int steps_max,
               Eigen::Vector3d* p_T) {
  double least = std::numeric_limits<double>::infinity();
  Eigen::Vector3d trial = *p_T;
  for (int step = 0; step <= steps_max; ++step) {
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    CauchySum sum(cauchy_sigma);
    for (const BundleObservation& o : observations) {
      LinearisedObservation l;
      if (!linearise(o, poses[index(o.pose)], trial, cauchy_sigma, &l)) {
        return least;
      }
      const Eigen::Matrix<double, 3, 2> weighted = l.weight * l.by_point.transpose();
      V.noalias() += weighted * l.by_point;
      gradient.noalias() += weighted * l.residual;
      sum.add(l.residual.squaredNorm());
    }
    const double cost = 0.5 * sum.value();
    if (!(cost < least)) {
      return least;
    }
    least = cost;
    *p_T = trial;
    trial -= damped_inverse(V, kSettlingDamping) * gradient;
  }
  return least;
}

}  // namespace

PointObservations::PointObservations(std::span<const BundleObservation> observations,
                                     std::size_t points)
    : first_(points + 1, 0), sorted_(observations.size()) {
  for (const BundleObservation& o : observations) {
    ++first_[index(o.point) + 1];
  }
  for (std::size_t i = 0; i < points; ++i) {
    first_[i + 1] += first_[i];
  }
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (const BundleObservation& o : observations) {
    sorted_[next[index(o.point)]++] = o;
  }
}

Eigen::Matrix3d damped_inverse(const Eigen::Matrix3d& V, double damping) {
  const double largest = V.diagonal().maxCoeff();
  if (!(largest > 0.0)) {
    return Eigen::Matrix3d::Zero();
  }
  Eigen::Matrix3d damped = V;
  damped.diagonal() += damping * V.diagonal().cwiseMax(kDiagonalMin * largest);
  return damped.inverse();
}

double bundle_cost(const BundleProblem& problem, double cauchy_sigma) {
  CauchySum sum(cauchy_sigma);
  for (const BundleObservation& o : problem.observations) {
    Eigen::Vector2d x;
    if (!reproject(problem.poses[index(o.pose)], problem.points_T[index(o.point)], &x)) {
      return std::numeric_limits<double>::infinity();
    }
    sum.add((x - o.normalised).squaredNorm() / (o.sigma_normalised * o.sigma_normalised));
  }
  return 0.5 * sum.value();
}

double settle_point(std::span<const BundleObservation> observations,
                    std::span<const InverseDepthPose> poses,
                    double cauchy_sigma,
                    int steps_max,
                    Eigen::Vector3d* p_T) {
  return with_avx2([&] { return settled(observations, poses, cauchy_sigma, steps_max, p_T); });
}

double settle_points(const BundleProblem& problem, const BundleOptions& options) {
  const PointObservations by_point(problem.observations, problem.points_T.size());
  double cost = 0.0;
  for (std::size_t i = 0; i < problem.points_T.size(); ++i) {
    const int steps_max = problem.point_fixed[i] == 0 ? options.iterations_max : 0;
    cost += settle_point(
        by_point.of(i), problem.poses, options.cauchy_sigma, steps_max, &problem.points_T[i]);
  }
  return cost;
}

}  // namespace polhode
