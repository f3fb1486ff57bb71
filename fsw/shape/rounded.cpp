#include "shape/rounded.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Normal9 = Eigen::Matrix<double, 9, 9>;

constexpr std::size_t kPointsMin = 20;  // twice the unknowns
constexpr int kRounds = 5;              // reweighted solutions; chosen, later ones change little

/// Terms of a quadric x'Ax + b'x = 1.
Vector9 terms(const Eigen::Vector3d& p) {
  Vector9 t;
  t << p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), 2.0 * p.y() * p.z(), 2.0 * p.x() * p.z(),
      2.0 * p.x() * p.y(), p;
  return t;
}

/// In centred coordinates; none where the quadric is no ellipsoid.
std::optional<Ellipsoid> ellipsoid_of(const Vector9& q) {
  // Chosen: the middle of a body more than six times as long as wide is a cylinder.
  constexpr double kLongest = 6.0;
  Eigen::Matrix3d A;
  A << q(0), q(5), q(4), q(5), q(1), q(3), q(4), q(3), q(2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  const Eigen::Vector3d& values = eigen.eigenvalues();
  if (!(values(0) * kLongest * kLongest > values(2)) || !(values(0) > 0.0)) {
    return std::nullopt;
  }
  Ellipsoid e;
  e.centre_T = -0.5 * A.ldlt().solve(q.tail<3>());
  const double level = 1.0 + e.centre_T.dot(A * e.centre_T);
  e.shape = A / level;
  return e;
}

}  // namespace

double Ellipsoid::distance(const Eigen::Vector3d& point_T) const {
  const Eigen::Vector3d apart = point_T - centre_T;
  const Eigen::Vector3d by = shape * apart;
  const double slope = 2.0 * by.norm();
  return slope > 0.0 ? (apart.dot(by) - 1.0) / slope : -1.0 / std::sqrt(shape.trace());
}

Result<Ellipsoid> fit_ellipsoid(std::span<const Eigen::Vector3d> points_T, double band) {
  if (points_T.size() < kPointsMin) {
    return ErrorCode::kTooFewObservations;
  }
  const Eigen::Vector3d mean_T = centroid_T(points_T);
  std::optional<Ellipsoid> found;
  for (int round = 0; round < kRounds; ++round) {
    Normal9 H = Normal9::Zero();
    Vector9 g = Vector9::Zero();
    for (const Eigen::Vector3d& point_T : points_T) {
      const Eigen::Vector3d p = point_T - mean_T;
      double weight = 1.0;
      if (found) {
        const double part = 2.0 * found->distance(p) / band;
        weight = 1.0 / (1.0 + part * part);
      }
      const Vector9 t = terms(p);
      H += weight * t * t.transpose();
      g += weight * t;
    }
    const Vector9 q = H.ldlt().solve(g);
    found = q.allFinite() ? ellipsoid_of(q) : std::nullopt;
    if (!found) {
      return ErrorCode::kDegenerate;
    }
  }
  found->centre_T += mean_T;
  return *found;
}

bool is_rounded(std::span<const Eigen::Vector3d> points_T, const Cylinder& cylinder, double band) {
  // Chosen: a margin in favour of the cylinder, since an ellipsoid has four unknowns more.
  constexpr double kMoreThanCylinder = 1.1;
  FixedVector<Eigen::Vector3d, limits::kCloudPoints> fitted;
  for (std::size_t i = 0; i < points_T.size(); i += 2) {
    (void)fitted.push_back(points_T[i]);
  }
  const Result<Ellipsoid> ellipsoid = fit_ellipsoid(fitted.view(), band);
  if (!ellipsoid) {
    return false;
  }
  std::size_t on_ellipsoid = 0;
  std::size_t on_cylinder = 0;
  for (std::size_t i = 1; i < points_T.size(); i += 2) {
    const double height = cylinder.axis_T.dot(points_T[i] - cylinder.centre_T);
    const double beyond = std::abs(height) - 0.5 * cylinder.length;
    const double outside = cylinder.distance(points_T[i]);
    const bool on_round = std::abs(outside) <= band && beyond <= band;
    const bool on_end = outside <= band && std::abs(beyond) <= band;
    on_cylinder += on_round || on_end ? 1U : 0U;
    on_ellipsoid += std::abs(ellipsoid.value().distance(points_T[i])) <= band ? 1U : 0U;
  }
  return static_cast<double>(on_ellipsoid) > kMoreThanCylinder * static_cast<double>(on_cylinder);
}

}  // namespace polhode
