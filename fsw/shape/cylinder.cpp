#include "shape/cylinder.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/consensus.hpp"
#include "shape/grouped_covariance.hpp"
#include "shape/rectangle.hpp"

namespace polhode {
namespace {

// Cosine of the largest angle between a point's normal and the radial direction, 30 deg: room for
// the noise of a normal from a few neighbours, and for curvature among them.
constexpr double kRadialCosineMin = 0.866;
// Least angle between two normals of a hypothesis. Under 17 deg they do not determine an axis:
// their noise is 5 to 7 deg (decision 0053).
constexpr double kAxisSineMin = 0.3;
// Axes by the whole cloud: one from all normals, three from the spread of the points (decision
// 0053). An axis from two noisy normals deviates from the surface within the length. Every other
// hypothesis takes one of these, in turn.
constexpr std::size_t kVotedAxes = 4;
// Reweighted eigenvector solutions. Chosen; fewer may stop early, more cost little.
constexpr int kVoteRounds = 10;
// Sine of 6 deg, the noise of a normal (5 to 7 deg, decision 0053).
constexpr double kVoteSoftness = 0.1;
// Part of the best support from which a hypothesis is refined before the comparison. Chosen;
// smaller refines more and costs more, larger discards good hypotheses with a noisy axis.
constexpr double kPromising = 0.7;
// Chosen: Gauss-Newton steps of a hypothesis, and of the best one until its band has settled.
constexpr int kRefinementsEach = 3;
constexpr int kCylinderRefinements = 10;
// Sectors of 10 deg. Points over less than a quarter turn are explained by a plane as well.
constexpr std::size_t kSectors = 36;
constexpr std::size_t kSectorsMin = kSectors / 4;
// Refinement narrows the band to three sigma of its inliers, but not below this part of the search
// band. Chosen: the search band may be 2.5 sigma, and this keeps most inliers of a fit too good by
// chance.
constexpr double kCylinderBandPartMin = 0.3;
constexpr double kCylinderBand_sigmas = 3.0;
// Five unknowns, and one point to check them.
constexpr std::size_t kFitPointsMin = 6;
// Planes draw from the streams below limits::kPlanes; this one differs from all of them.
constexpr std::uint64_t kRngStream = 100;

using Normal5 = Eigen::Matrix<double, 5, 5>;
using Vector5 = Eigen::Matrix<double, 5, 1>;

struct CylinderSupport {
  std::span<const Eigen::Vector3d> points_T;
  const SurfaceNormals& normals;

  [[nodiscard]] bool contains(const Cylinder& c, double band, std::size_t i) const {
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
      sum += contains(c, band, i) ? 1U : 0U;
    }
    return sum;
  }
};

/// The direction most orthogonal to all normals, by robust reweighting. Normals of a round body lie
/// on a great circle, those of its ends at the poles of that circle.
Eigen::Vector3d axis_of_directions(const SurfaceNormals& normals, const CloudIndices& directed) {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (int round = 0; round < kVoteRounds; ++round) {
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const std::uint16_t i : directed) {
      const Eigen::Vector3d& n = normals[i].normal_T;
      const double off = n.dot(axis);  // 0 at first: equal weights
      const double weight = 1.0 / (1.0 + off * off / (kVoteSoftness * kVoteSoftness));
      scatter += weight * n * n.transpose();
    }
    axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  }
  return axis;
}

using Axes = std::array<Eigen::Vector3d, kVotedAxes>;

/// Candidate axes by the whole cloud: orthogonal to its normals, and along its spread.
Axes voted_axes(const CylinderSupport& support, const CloudIndices& directed) {
  const Eigen::Vector3d mean_T = centroid_T(support.points_T);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point_T : support.points_T) {
    scatter += (point_T - mean_T) * (point_T - mean_T).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  return {axis_of_directions(support.normals, directed),
          eigen.eigenvectors().col(2),
          eigen.eigenvectors().col(0),
          eigen.eigenvectors().col(1)};
}

/// Circle across the axis through three points. Nothing where they are nearly collinear.
std::optional<Cylinder> circle_through(const Eigen::Vector3d& axis_T,
                                       const Eigen::Vector3d& p,
                                       const Eigen::Vector3d& q,
                                       const Eigen::Vector3d& r) {
  const auto across = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - axis_T * axis_T.dot(v));
  };
  const Eigen::Vector3d a = across(q - p);
  const Eigen::Vector3d b = across(r - p);
  const double area = a.cross(b).dot(axis_T);
  if (!(std::abs(area) >= kAxisSineMin * a.norm() * b.norm()) || !(std::abs(area) > 0.0)) {
    return std::nullopt;
  }
  const Eigen::Vector3d to_centre =
      (b.squaredNorm() * a - a.squaredNorm() * b).cross(axis_T) / (-2.0 * area);
  return Cylinder{.axis_T = axis_T, .centre_T = p + to_centre, .radius = to_centre.norm()};
}

/// Axis: one of the candidates, or orthogonal to two normals. Circle: through three points.
std::optional<Cylinder> hypothesis(const CylinderSupport& support,
                                   const CloudIndices& directed,
                                   const Axes& axes,
                                   const Sample<3>& sample,
                                   std::size_t number) {
  const std::size_t a = directed[sample[0]];
  const std::size_t b = directed[sample[1]];
  const std::size_t c = directed[sample[2]];
  Eigen::Vector3d axis_T = axes[number / 2 % kVotedAxes];
  if (number % 2 == 1) {
    axis_T = support.normals[a].normal_T.cross(support.normals[b].normal_T);
    if (!(axis_T.norm() >= kAxisSineMin)) {
      return std::nullopt;
    }
    axis_T.normalize();
  }
  return circle_through(axis_T, support.points_T[a], support.points_T[b], support.points_T[c]);
}

/// Index of the sector, of `count` equal ones, that a direction lies in.
std::size_t sector(double y, double x, std::size_t count) {
  const double turn = std::atan2(y, x) / (2.0 * std::numbers::pi) + 0.5;
  return std::min(count - 1, static_cast<std::size_t>(turn * static_cast<double>(count)));
}

/// Derivatives of the distance from the round surface by tilts, shifts across the axis and radius;
/// e1, e2 across the axis.
Vector5 derivative(const Cylinder& c,
                   const Eigen::Vector3d& e1,
                   const Eigen::Vector3d& e2,
                   const Eigen::Vector3d& point_T) {
  const Eigen::Vector3d apart = point_T - c.centre_T;
  const double height = c.axis_T.dot(apart);
  const Eigen::Vector3d radial = (apart - c.axis_T * height).normalized();
  Vector5 J;
  J << -height * radial.dot(e1), -height * radial.dot(e2), -radial.dot(e1), -radial.dot(e2), -1.0;
  return J;
}

/// Smooth weight (Cauchy), one half at half the band. Landmark noise has long tails, longer ones
/// outwards. A smooth weight keeps points from coming and going between steps.
double weight_of(double residual, double band) {
  const double part = 2.0 * residual / band;
  return 1.0 / (1.0 + part * part);
}

/// One Gauss-Newton step on the distances of the points that support it; unknowns: tilts, shifts
/// across the axis, radius.
bool refine(const CylinderSupport& support, double band, Cylinder& c, Normal5* information) {
  const Eigen::Vector3d e1 = c.axis_T.unitOrthogonal();
  const Eigen::Vector3d e2 = c.axis_T.cross(e1);
  Normal5 H = Normal5::Zero();
  Vector5 g = Vector5::Zero();
  double square = 0.0;
  c.inliers = 0;
  for (std::size_t i = 0; i < support.points_T.size(); ++i) {
    if (!support.contains(c, band, i)) {
      continue;
    }
    const double residual = c.distance(support.points_T[i]);
    const double weight = weight_of(residual, band);
    const Vector5 J = derivative(c, e1, e2, support.points_T[i]);
    H += weight * J * J.transpose();
    g += weight * residual * J;
    square += residual * residual;
    ++c.inliers;
  }
  if (c.inliers < kFitPointsMin) {
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

/// Covariance of the five unknowns, from the scatter of patches. Not less than by white noise.
Normal5 covariance_of(const CylinderSupport& support,
                      double band,
                      const Normal5& information,
                      const Cylinder& c) {
  // Patches of 30 deg by a quarter of the length. Chosen; more patches miss errors that are longer
  // than one, fewer do not reach the seven filled ones that GroupedCovariance needs.
  constexpr std::size_t kAround = 12;
  constexpr std::size_t kAlong = 4;
  const Eigen::Vector3d e1 = c.axis_T.unitOrthogonal();
  const Eigen::Vector3d e2 = c.axis_T.cross(e1);
  GroupedCovariance<5, kAround * kAlong> grouped;
  for (std::size_t i = 0; i < support.points_T.size(); ++i) {
    if (!support.contains(c, band, i)) {
      continue;
    }
    const Eigen::Vector3d apart = support.points_T[i] - c.centre_T;
    const double residual = c.distance(support.points_T[i]);
    const std::size_t around = sector(apart.dot(e2), apart.dot(e1), kAround);
    const double height = std::clamp(c.axis_T.dot(apart) / c.length + 0.5, 0.0, 1.0);
    const auto along = std::min(kAlong - 1, static_cast<std::size_t>(height * kAlong));
    grouped.add(around * kAlong + along,
                weight_of(residual, band) * residual * derivative(c, e1, e2, support.points_T[i]));
  }
  const Normal5 white = c.rms * c.rms * information.ldlt().solve(Normal5::Identity());
  return not_below(white, grouped.covariance(information));
}

/// Length, middle, coverage and sigmas of a refined cylinder.
void describe(const CylinderSupport& support,
              double band,
              double search_band,
              const Normal5& information,
              Cylinder& c) {
  const Eigen::Vector3d e1 = c.axis_T.unitOrthogonal();
  const Eigen::Vector3d e2 = c.axis_T.cross(e1);
  FixedVector<double, limits::kCloudPoints> heights;
  std::bitset<kSectors> sectors;
  c.inliers = 0;
  c.beside = 0;
  for (std::size_t i = 0; i < support.points_T.size(); ++i) {
    if (support.contains(c, band, i)) {
      const Eigen::Vector3d apart = support.points_T[i] - c.centre_T;
      sectors.set(sector(apart.dot(e2), apart.dot(e1), kSectors));
      POLHODE_ASSERT(heights.push_back(c.axis_T.dot(apart)), i);
      ++c.inliers;
    } else if (support.contains(c, 2.0 * search_band, i)) {
      ++c.beside;
    }
  }
  const Extent extent = robust_extent(heights.view());
  c.length = extent.most - extent.least;
  c.coverage_rad = 2.0 * std::numbers::pi * static_cast<double>(sectors.count()) / kSectors;
  c.centre_T += 0.5 * (extent.least + extent.most) * c.axis_T;
  if (!(c.length > 0.0)) {
    return;
  }
  const Normal5 covariance = covariance_of(support, band, information, c);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> tilt(
      Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  c.sigma_axis_rad = std::sqrt(std::max(0.0, tilt.eigenvalues()(1)));
  c.sigma_radius = std::sqrt(std::max(0.0, covariance(4, 4)));
}

/// Score of a hypothesis: its negative support. Promising hypotheses are refined first.
double score(const CylinderSupport& support, double band, double enough, Cylinder* c) {
  c->inliers = support.count(*c, band);
  if (static_cast<double>(c->inliers) < kPromising * -enough) {
    return enough;
  }
  Normal5 information;
  for (int k = 0; k < kRefinementsEach; ++k) {
    if (!refine(support, 2.0 * band, *c, &information)) {
      return kNoScore;
    }
  }
  c->inliers = support.count(*c, band);
  return -static_cast<double>(c->inliers);
}

/// The hypothesis with most support; without inliers when there is none.
Cylinder best_hypothesis(const CylinderSupport& support,
                         const CloudIndices& directed,
                         const CylinderSearch& search) {
  const Axes axes = voted_axes(support, directed);
  std::size_t number = 0;
  BestHypothesis<Cylinder> best{.score = 0.0};  // some inliers
  find_consensus<3>(
      {.points = directed.size(),
       .draws_max = search.iterations_max,
       .seed = search.seed,
       .stream = kRngStream},
      [&](const Sample<3>& s) { return hypothesis(support, directed, axes, s, number++); },
      [&](Cylinder* c, double enough) { return score(support, search.distance_max, enough, c); },
      &best);
  return best.model;
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
  if (points_T.size() < search.inliers_min || directed.size() < 3) {
    return ErrorCode::kTooFewObservations;
  }
  const CylinderSupport support{.points_T = points_T, .normals = normals};
  Normal5 information = Normal5::Identity();
  Cylinder best = best_hypothesis(support, directed, search);
  if (best.inliers < search.inliers_min) {
    return ErrorCode::kNoConsensus;
  }
  double band = 2.0 * search.distance_max;  // wide at first: the axis is still rough
  for (int i = 0; i < kCylinderRefinements; ++i) {
    if (!refine(support, band, best, &information)) {
      return ErrorCode::kNoConsensus;
    }
    band = std::clamp(kCylinderBand_sigmas * best.rms,
                      kCylinderBandPartMin * search.distance_max,
                      search.distance_max);
  }
  describe(support, band, search.distance_max, information, best);
  // less a margin for rounding
  const double coverage_min_rad = 2.0 * std::numbers::pi * kSectorsMin / kSectors - 1e-9;
  if (best.inliers < search.inliers_min || best.coverage_rad < coverage_min_rad) {
    return ErrorCode::kNoConsensus;
  }
  return best;
}

}  // namespace polhode
