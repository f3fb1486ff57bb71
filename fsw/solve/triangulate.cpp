#include "solve/triangulate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/reprojection.hpp"
#include "solve/small_fit.hpp"

namespace polhode {
namespace {

// Least squared sine of the angle between rays. Under 1e-6 rad their intersection is rounding.
constexpr double kParallel2 = 1e-12;
// Least depth, relative to the target's distance; below it the point counts as behind the camera.
// Chosen.
constexpr double kRelativeDepthMin = 1e-6;
// A bound only: the linear solution is near the minimum.
constexpr int kStepsMax = 5;
// First damping: next to none, as the linear solution is nearly the minimum.
constexpr double kDampingFirst = 1e-6;

Eigen::Vector3d ray_T(const RayObservation& observation) {
  return (observation.pose.R_CT.transpose() * observation.normalised.homogeneous()).normalized();
}

double largest_parallax_rad(std::span<const RayObservation> observations) {
  double cosine_min = 1.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      cosine_min = std::min(cosine_min, ray_T(observations[i]).dot(ray_T(observations[j])));
    }
  }
  return std::acos(std::clamp(cosine_min, -1.0, 1.0));
}

/// The point nearest to all rays.
bool nearest_to_rays(std::span<const RayObservation> observations, Eigen::Vector3d* p_T) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const RayObservation& observation : observations) {
    const Eigen::Vector3d d = ray_T(observation);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * observation.pose.camera_T();
  }
  // Parallel rays leave depth undetermined: the smallest eigenvalue is the squared sine of the
  // angle between them.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  if (!(eigen.eigenvalues()(0) > kParallel2 * eigen.eigenvalues()(2))) {
    return false;
  }
  *p_T = A.ldlt().solve(b);
  return p_T->allFinite();
}

/// @return false where the point lies behind a camera.
bool linearise(std::span<const RayObservation> observations,
               const Eigen::Vector3d& p_T,
               SmallEquations<3>* at) {
  *at = {};
  for (const RayObservation& observation : observations) {
    const Eigen::Vector3d p_C = observation.pose.to_camera(p_T);
    if (!(p_C.z() > kRelativeDepthMin * observation.pose.p_CT.norm())) {
      return false;
    }
    const Eigen::Vector2d x = p_C.hnormalized();
    const double w = 1.0 / observation.sigma_normalised;
    const Eigen::Matrix<double, 2, 3> J =
        w * projection_jacobian(observation.pose, p_T).rightCols<3>() * observation.pose.R_CT;
    const Eigen::Vector2d residual = w * (x - observation.normalised);
    at->H += J.transpose() * J;
    at->g += J.transpose() * residual;
    at->cost += residual.squaredNorm();
  }
  return true;
}

}  // namespace

Result<TriangulatedPoint> triangulate(std::span<const RayObservation> observations) {
  if (observations.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  TriangulatedPoint point;
  if (!nearest_to_rays(observations, &point.p_T)) {
    return ErrorCode::kDegenerate;
  }
  const auto at = [&](const Eigen::Vector3d& p_T, SmallEquations<3>* equations) {
    return linearise(observations, p_T, equations);
  };
  SmallEquations<3> n;
  if (minimise(at, {.steps_max = kStepsMax, .damping_first = kDampingFirst}, &point.p_T, &n) < 0) {
    return ErrorCode::kDegenerate;
  }
  point.covariance_T = n.H.inverse();
  point.chi2 = n.cost;
  point.parallax_rad = largest_parallax_rad(observations);
  if (!point.covariance_T.allFinite()) {
    return ErrorCode::kDegenerate;
  }
  return point;
}

}  // namespace polhode
