// Re-solves points for given poses.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "geometry/reprojection.hpp"
#include "solve/bundle_problem.hpp"
#include "solve/cauchy_loss.hpp"

namespace polhode {

/// The observations of each point, in the order of the problem.
class PointObservations {
 public:
  PointObservations(std::span<const BundleObservation> observations, std::size_t points);
  [[nodiscard]] std::span<const BundleObservation> of(std::size_t point) const {
    return std::span(sorted_).subspan(first_[point], first_[point + 1] - first_[point]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<BundleObservation> sorted_;
};

/// Residual and derivatives of one observation, in sigma.
struct LinearisedObservation {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> by_pose;  ///< (phi, uvs)
  Eigen::Matrix<double, 2, 3> by_point;
  double weight = 0.0;  ///< of the Cauchy loss
};

/// @return false where the point lies behind the camera.
inline bool linearise(const BundleObservation& o,
                      const InverseDepthPose& pose,
                      const Eigen::Vector3d& p_T,
                      double cauchy_sigma,
                      LinearisedObservation* out) {
  Eigen::Vector2d x;
  ReprojectionJacobians J;
  if (!reproject(pose, p_T, &x, &J)) {
    return false;
  }
  const double inverse_sigma = 1.0 / o.sigma_normalised;
  out->residual = inverse_sigma * (x - o.normalised);
  out->by_pose.leftCols<3>() = inverse_sigma * J.rotation;
  out->by_pose.rightCols<3>() = inverse_sigma * J.uvs;
  out->by_point = inverse_sigma * J.point;
  out->weight = cauchy_weight(out->residual.squaredNorm(), cauchy_sigma);
  return true;
}

/// Inverse of V with parts of its own diagonal added; zero where V is zero. A diagonal element near
/// zero, of an axis without information, counts as a part of the largest.
Eigen::Matrix3d damped_inverse(const Eigen::Matrix3d& V, double damping);

/// Half the robust sum of squares; infinite where a point lies behind a camera that sees it.
double bundle_cost(const BundleProblem& problem, double cauchy_sigma);

/// Gauss-Newton steps of one point for the poses, for as long as the cost falls. Valid after pose
/// steps of several degrees, where a linear model of all unknowns fails.
/// @param p_T  in, out.
/// @return half the robust sum of squares of its observations; infinite where it lies behind a
/// camera, p_T then as it was.
double settle_point(std::span<const BundleObservation> observations,
                    std::span<const InverseDepthPose> poses,
                    double cauchy_sigma,
                    int steps_max,
                    Eigen::Vector3d* p_T);

/// The same for all points that are not fixed.
/// @return bundle_cost() then.
double settle_points(const BundleProblem& problem, const BundleOptions& options);

}  // namespace polhode
