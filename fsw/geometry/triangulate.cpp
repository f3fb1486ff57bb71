#include "geometry/triangulate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/reprojection.hpp"

namespace polhode {
namespace {

Eigen::Vector3d ray_T(const Sighting& sighting) {
  return (sighting.pose.R_CT.transpose() * sighting.normalised.homogeneous()).normalized();
}

double largest_parallax_rad(std::span<const Sighting> sightings) {
  double cosine_min = 1.0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      cosine_min = std::min(cosine_min, ray_T(sightings[i]).dot(ray_T(sightings[j])));
    }
  }
  return std::acos(std::clamp(cosine_min, -1.0, 1.0));
}

/// Point nearest to all rays.
bool nearest_to_rays(std::span<const Sighting> sightings, Eigen::Vector3d* p_T) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Sighting& sighting : sightings) {
    const Eigen::Vector3d d = ray_T(sighting);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * sighting.pose.camera_T();
  }
  // Parallel rays leave their own direction open: the smallest eigenvalue is the squared sine of
  // the angle between them.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  if (!(eigen.eigenvalues()(0) > 1e-12 * eigen.eigenvalues()(2))) {
    return false;
  }
  *p_T = A.ldlt().solve(b);
  return p_T->allFinite();
}

struct NormalEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  double chi2 = 0.0;
  bool in_front = true;
};

NormalEquations linearise(std::span<const Sighting> sightings, const Eigen::Vector3d& p_T) {
  NormalEquations n;
  for (const Sighting& sighting : sightings) {
    const Eigen::Vector3d p_C = sighting.pose.to_camera(p_T);
    if (!(p_C.z() > 1e-6 * sighting.pose.p_CT.norm())) {
      n.in_front = false;
      return n;
    }
    const Eigen::Vector2d x = p_C.hnormalized();
    const double w = 1.0 / sighting.sigma_normalised;
    const Eigen::Matrix<double, 2, 3> J =
        w * projection_jacobian(sighting.pose, p_T).rightCols<3>() * sighting.pose.R_CT;
    const Eigen::Vector2d residual = w * (x - sighting.normalised);
    n.H += J.transpose() * J;
    n.g += J.transpose() * residual;
    n.chi2 += residual.squaredNorm();
  }
  return n;
}

}  // namespace

Result<TriangulatedPoint> triangulate(std::span<const Sighting> sightings) {
  if (sightings.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  TriangulatedPoint point;
  if (!nearest_to_rays(sightings, &point.p_T)) {
    return ErrorCode::kDegenerate;
  }
  constexpr int kIterations = 5;
  NormalEquations n = linearise(sightings, point.p_T);
  for (int i = 0; i < kIterations && n.in_front; ++i) {
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(n.H);
    const Eigen::Vector3d step = ldlt.solve(n.g);
    if (!step.allFinite()) {
      return ErrorCode::kDegenerate;
    }
    const NormalEquations next = linearise(sightings, point.p_T - step);
    if (!next.in_front || next.chi2 > n.chi2) {
      break;
    }
    point.p_T -= step;
    n = next;
  }
  if (!n.in_front) {
    return ErrorCode::kDegenerate;
  }
  point.covariance_T = n.H.inverse();
  point.chi2 = n.chi2;
  point.parallax_rad = largest_parallax_rad(sightings);
  if (!point.covariance_T.allFinite()) {
    return ErrorCode::kDegenerate;
  }
  return point;
}

}  // namespace polhode
