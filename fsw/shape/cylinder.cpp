#include "shape/cylinder.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>

#include "base/rng.hpp"
#include "shape/rectangle.hpp"

namespace polhode {
namespace {

constexpr double kRadialCosineMin =
    0.866;  // 30 deg: direction noise of a dozen neighbours, and curvature among them
constexpr double kSampleSineMin = 0.3;  // two directions less than 17 deg apart do not fix an axis
constexpr int kRefinements = 10;
constexpr std::size_t kSectors = 36;
constexpr std::size_t kSectorsMin = 9;  // 90 deg
// Refinement narrows the band to three sigma of what is in it, but not below this part of the
// search's.
constexpr double kBandPartMin = 0.3;

using Normal5 = Eigen::Matrix<double, 5, 5>;
using Vector5 = Eigen::Matrix<double, 5, 1>;

struct Support {
  std::span<const Eigen::Vector3d> points_T;
  const SurfaceNormals& normals;

  [[nodiscard]] bool holds(const Cylinder& c, double band, std::size_t i) const {
    const Eigen::Vector3d apart = points_T[i] - c.centre_T;
    const Eigen::Vector3d radial = apart - c.axis_T * c.axis_T.dot(apart);
    const double distance = radial.norm();
    return std::abs(distance - c.radius) <= band &&
           (!normals[i].reliable ||
            std::abs(normals[i].normal_T.dot(radial)) >= kRadialCosineMin * distance);
  }
  [[nodiscard]] std::size_t count(const Cylinder& c, double band) const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < points_T.size(); ++i) {
      sum += holds(c, band, i) ? 1U : 0U;
    }
    return sum;
  }
};

/// Axis across both directions, through the meeting point of the two lines along them.
bool hypothesis(const Eigen::Vector3d& p,
                const Eigen::Vector3d& n,
                const Eigen::Vector3d& q,
                const Eigen::Vector3d& m,
                Cylinder& c) {
  const Eigen::Vector3d cross = n.cross(m);
  const double sine = cross.norm();
  if (!(sine >= kSampleSineMin)) {
    return false;
  }
  c.axis_T = cross / sine;
  // p + s n and q + t m meet in the plane across the axis.
  const double s = (q - p).cross(m).dot(c.axis_T) / sine;
  const double t = (q - p).cross(n).dot(c.axis_T) / sine;
  c.centre_T = p + s * n;
  c.radius = 0.5 * (std::abs(s) + std::abs(t));
  return std::abs(std::abs(s) - std::abs(t)) <= 0.2 * c.radius;
}

/// One Gauss-Newton step on distance - radius over the inliers; unknowns: tilts, shifts across the
/// axis, radius.
bool refine(const Support& support, double band, Cylinder& c, Normal5* information) {
  const Eigen::Vector3d e1 = c.axis_T.unitOrthogonal();
  const Eigen::Vector3d e2 = c.axis_T.cross(e1);
  Normal5 H = Normal5::Zero();
  Vector5 g = Vector5::Zero();
  double square = 0.0;
  c.inliers = 0;
  for (std::size_t i = 0; i < support.points_T.size(); ++i) {
    if (!support.holds(c, band, i)) {
      continue;
    }
    const Eigen::Vector3d apart = support.points_T[i] - c.centre_T;
    const double height = c.axis_T.dot(apart);
    const Eigen::Vector3d radial = (apart - c.axis_T * height).normalized();
    const double residual = c.distance(support.points_T[i]);
    Vector5 J;
    J << -height * radial.dot(e1), -height * radial.dot(e2), -radial.dot(e1), -radial.dot(e2), -1.0;
    H += J * J.transpose();
    g += J * residual;
    square += residual * residual;
    ++c.inliers;
  }
  if (c.inliers < 6) {
    return false;
  }
  const Eigen::LDLT<Normal5> ldlt(H);
  const Vector5 step = ldlt.solve(g);
  if (!step.allFinite() || !(ldlt.vectorD().minCoeff() > 0.0)) {
    return false;
  }
  c.rms = std::sqrt(square / static_cast<double>(c.inliers));
  c.axis_T = (c.axis_T - step(0) * e1 - step(1) * e2).normalized();
  c.centre_T -= step(2) * e1 + step(3) * e2;
  c.radius -= step(4);
  *information = H;
  return c.radius > 0.0;
}

/// Length, middle, coverage and sigmas of a refined cylinder.
void describe(const Support& support, double band, const Normal5& information, Cylinder& c) {
  const Eigen::Vector3d e1 = c.axis_T.unitOrthogonal();
  const Eigen::Vector3d e2 = c.axis_T.cross(e1);
  FixedVector<double, limits::kCloudPoints> heights;
  std::bitset<kSectors> sectors;
  c.inliers = 0;
  for (std::size_t i = 0; i < support.points_T.size(); ++i) {
    if (support.holds(c, band, i)) {
      const Eigen::Vector3d apart = support.points_T[i] - c.centre_T;
      const double turn = std::atan2(apart.dot(e2), apart.dot(e1)) / (2.0 * std::numbers::pi) + 0.5;
      sectors.set(std::min(kSectors - 1, static_cast<std::size_t>(turn * kSectors)));
      POLHODE_ASSERT(heights.push_back(c.axis_T.dot(apart)), i);
      ++c.inliers;
    }
  }
  const Extent extent = robust_extent(heights.view());
  c.centre_T += 0.5 * (extent.least + extent.most) * c.axis_T;
  c.length = extent.most - extent.least;
  c.coverage_rad = 2.0 * std::numbers::pi * static_cast<double>(sectors.count()) / kSectors;
  const Normal5 covariance = c.rms * c.rms * information.ldlt().solve(Normal5::Identity());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> tilt(
      Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  c.sigma_axis_rad = std::sqrt(std::max(0.0, tilt.eigenvalues()(1)));
  c.sigma_radius = std::sqrt(std::max(0.0, covariance(4, 4)));
}

}  // namespace

Result<Cylinder> find_cylinder(std::span<const Eigen::Vector3d> points_T,
                               const SurfaceNormals& normals,
                               const CylinderSearch& search) {
  POLHODE_ASSERT(normals.size() == points_T.size(), normals.size());
  CloudIndices directed;
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    if (normals[i].reliable) {
      POLHODE_ASSERT(directed.push_back(static_cast<std::uint16_t>(i)), i);
    }
  }
  if (points_T.size() < search.inliers_min || directed.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  const Support support{.points_T = points_T, .normals = normals};
  Rng rng(search.seed, 100);
  Cylinder best;
  const auto bound = static_cast<std::uint32_t>(directed.size());
  for (int i = 0; i < search.iterations_max; ++i) {
    const std::uint16_t a = directed[rng.below(bound)];
    const std::uint16_t b = directed[rng.below(bound)];
    Cylinder c;
    if (!hypothesis(points_T[a], normals[a].normal_T, points_T[b], normals[b].normal_T, c)) {
      continue;
    }
    c.inliers = support.count(c, search.distance_max);
    if (c.inliers > best.inliers) {
      best = c;
    }
  }
  if (best.inliers < search.inliers_min) {
    return ErrorCode::kNoConsensus;
  }
  Normal5 information = Normal5::Identity();
  double band = 2.0 * search.distance_max;  // the first hypothesis hangs on two points' directions
  for (int i = 0; i < kRefinements; ++i) {
    if (!refine(support, band, best, &information)) {
      return ErrorCode::kNoConsensus;
    }
    band = std::clamp(3.0 * best.rms, kBandPartMin * search.distance_max, search.distance_max);
  }
  describe(support, band, information, best);
  const double coverage_min_rad = 2.0 * std::numbers::pi * kSectorsMin / kSectors - 1e-9;
  if (best.inliers < search.inliers_min || best.coverage_rad < coverage_min_rad) {
    return ErrorCode::kNoConsensus;
  }
  return best;
}

}  // namespace polhode
