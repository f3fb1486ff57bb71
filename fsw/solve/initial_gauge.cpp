// The seven gauge freedoms of an initialisation: fixes them, and gives the covariance with them
// fixed.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/median.hpp"
#include "geometry/so3.hpp"
#include "solve/initial_adjustment.hpp"

namespace polhode {
namespace {

using Workspace = InitialAdjustmentWorkspace;
using Matrix37 = Eigen::Matrix<double, 3, 7>;
using Matrix67 = Eigen::Matrix<double, 6, 7>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using GaugeByCameras = Eigen::Matrix<double, Eigen::Dynamic, 7, 0, Workspace::kCameraParameters, 7>;
// Points farther from the centre than this many median extents are wrong. Chosen: larger lets wrong
// points set the extent, smaller cuts booms off.
constexpr double kExtentsMax = 3.0;
// Fewest known points. Chosen.
constexpr int kPointsMin = 4;

/// Median by coordinates along the rows of R_NT; in T.
Eigen::Vector3d median_point(const InitialGeometryView& g, const Eigen::Matrix3d& R_NT) {
  Eigen::Vector3d centre_N;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    FixedVector<double, limits::kInitialTracks> values;
    for (std::size_t i = 0; i < g.points_T.size(); ++i) {
      if (g.known[i] != 0) {
        (void)values.push_back(R_NT.row(axis).dot(g.points_T[i]));
      }
    }
    centre_N(axis) = median(values.view());
  }
  return R_NT.transpose() * centre_N;
}

double robust_extent(const InitialGeometryView& g, const Eigen::Vector3d& centre) {
  FixedVector<double, limits::kInitialTracks> distances;
  for (std::size_t i = 0; i < g.points_T.size(); ++i) {
    if (g.known[i] != 0) {
      (void)distances.push_back((g.points_T[i] - centre).norm());
    }
  }
  const double limit = kExtentsMax * median(distances.view());
  double sum = 0.0;
  int count = 0;
  for (const double distance : distances) {
    if (distance <= limit) {
      sum += distance * distance;
      ++count;
    }
  }
  return std::sqrt(sum / std::max(1, count));
}

int count_known(std::span<const std::uint8_t> known) {
  return static_cast<int>(
      std::count_if(known.begin(), known.end(), [](std::uint8_t k) { return k != 0; }));
}

/// Derivatives of a point by the gauge: rotation of T (3), shift of T (3), scale (1).
Matrix37 point_gauge(const Eigen::Vector3d& p_T) {
  Matrix37 G;
  G << -hat(p_T), Eigen::Matrix3d::Identity(), p_T;
  return G;
}

/// Derivatives of a pose (phi, uvs) by the gauge.
Matrix67 camera_gauge(const InverseDepthPose& pose) {
  const double s = pose.uvs.z();
  Eigen::Matrix3d by_position;  // d uvs / d p_CT
  by_position << s, 0.0, -s * pose.uvs.x(), 0.0, s, -s * pose.uvs.y(), 0.0, 0.0, -s * s;
  Matrix67 G = Matrix67::Zero();
  G.topLeftCorner<3, 3>() = -pose.R_CT;
  G.block<3, 3>(3, 3) = -by_position * pose.R_CT;
  G(5, 6) = -s;
  return G;
}

/// Derivatives of the gauge constraints by a point: rows are centroid (3) and extent (1). The
/// attitude is the camera's.
Eigen::Matrix<double, 7, 3> point_constraint(const Eigen::Vector3d& p_T) {
  Eigen::Matrix<double, 7, 3> h = Eigen::Matrix<double, 7, 3>::Zero();
  h.topRows<3>().setIdentity();
  h.row(3) = p_T.transpose();
  return h;
}

struct GaugeFix {
  Eigen::MatrixXd camera_covariance;  ///< in an arbitrary gauge
  GaugeByCameras
      by_cameras;  ///< transposed derivatives of the constraints by the cameras, points following
  Matrix7 constraint_covariance;
  Matrix7 gauge_from_constraints;
};

std::size_t first_posed(const InitialGeometryView& g) {
  std::size_t f = 0;
  while (f < g.posed.size() && g.posed[f] == 0) {
    ++f;
  }
  return f;
}

/// Adds information in the gauge directions only, so that the reduced system is invertible.
bool invert_cameras(const InitialGeometryView& g, Workspace* w, GaugeFix* fix) {
  const Eigen::Index size = w->reduced.rows();
  GaugeByCameras G = GaugeByCameras::Zero(size, 7);
  for (std::size_t f = 0; f < g.poses.size(); ++f) {
    if (g.posed[f] != 0) {
      G.middleRows<6>(static_cast<Eigen::Index>(6 * f)) = camera_gauge(g.poses[f]);
    }
  }
  G = G * G.colwise().norm().cwiseInverse().asDiagonal();
  const double strength = w->reduced.trace() / static_cast<double>(size);
  w->reduced.noalias() += strength * G * G.transpose();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(w->reduced);
  if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) {
    return false;
  }
  fix->camera_covariance = ldlt.solve(Eigen::MatrixXd::Identity(size, size));
  return fix->camera_covariance.allFinite() &&
         (fix->camera_covariance.diagonal().array() >= 0.0).all();
}

void collect_constraints(std::span<const TrackObservation> observations,
                         const InitialGeometryView& g,
                         const Workspace& w,
                         GaugeFix* fix) {
  const auto first = static_cast<Eigen::Index>(6 * first_posed(g));
  fix->by_cameras = GaugeByCameras::Zero(w.reduced.rows(), 7);
  fix->by_cameras.block<3, 3>(first, 4).setIdentity();
  fix->constraint_covariance.setZero();
  Matrix7 by_gauge = Matrix7::Zero();
  by_gauge.bottomRows<3>() = camera_gauge(g.poses[first_posed(g)]).topRows<3>();
  int last_track = -1;
  Eigen::Matrix3d V_inverse = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 7, 3> h;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto track = static_cast<std::size_t>(observations[i].track);
    if (g.known[track] == 0) {
      continue;
    }
    if (observations[i].track != last_track) {
      last_track = observations[i].track;
      V_inverse = w.point_blocks[track].V.inverse();
      h = point_constraint(g.points_T[track]);
      fix->constraint_covariance += h * V_inverse * h.transpose();
      by_gauge += h * point_gauge(g.points_T[track]);
    }
    if (w.blocks[i].frame >= 0) {
      fix->by_cameras.middleRows<6>(6 * w.blocks[i].frame) -=
          w.blocks[i].W * V_inverse * h.transpose();
    }
  }
  fix->constraint_covariance +=
      fix->by_cameras.transpose() * fix->camera_covariance * fix->by_cameras;
  fix->gauge_from_constraints = by_gauge.inverse();
}

/// Covariance of one point after projection onto the constraints.
Eigen::Matrix3d point_covariance(std::span<const TrackObservation> observations,
                                 std::size_t begin,
                                 std::size_t end,
                                 const Eigen::Vector3d& p_T,
                                 const Workspace& w,
                                 const GaugeFix& fix) {
  const auto track = static_cast<std::size_t>(observations[begin].track);
  const Eigen::Matrix3d V_inverse = w.point_blocks[track].V.inverse();
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, Workspace::kCameraParameters, 3> by_cameras =
      Eigen::Matrix<double, Eigen::Dynamic, 3, 0, Workspace::kCameraParameters, 3>::Zero(
          w.reduced.rows(), 3);
  for (std::size_t i = begin; i < end; ++i) {
    if (w.blocks[i].frame >= 0) {
      by_cameras.middleRows<6>(6 * w.blocks[i].frame) -= w.blocks[i].W * V_inverse;
    }
  }
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, Workspace::kCameraParameters> spread =
      by_cameras.transpose() * fix.camera_covariance;
  const Eigen::Matrix3d own = V_inverse + spread * by_cameras;
  const Matrix37 with_constraints =
      V_inverse * point_constraint(p_T).transpose() + spread * fix.by_cameras;
  const Matrix37 A = point_gauge(p_T) * fix.gauge_from_constraints;
  return own - A * with_constraints.transpose() - with_constraints * A.transpose() +
         A * fix.constraint_covariance * A.transpose();
}

}  // namespace

bool initial_point_covariances(std::span<const TrackObservation> observations,
                               const InitialGeometryView& geometry,
                               const InitialAdjustmentOptions& options,
                               std::span<Eigen::Matrix3d> covariances,
                               Workspace* workspace) {
  POLHODE_ASSERT(covariances.size() == geometry.points_T.size(), covariances.size());
  if (count_known(geometry.known) < kPointsMin ||
      !reduced_camera_system(observations, geometry, options, workspace)) {
    return false;
  }
  GaugeFix fix;
  if (!invert_cameras(geometry, workspace, &fix)) {
    return false;
  }
  collect_constraints(observations, geometry, *workspace, &fix);
  if (!fix.gauge_from_constraints.allFinite() || !fix.constraint_covariance.allFinite()) {
    return false;
  }
  std::fill(covariances.begin(), covariances.end(), Eigen::Matrix3d::Zero());
  for (std::size_t begin = 0; begin < observations.size();) {
    const auto track = static_cast<std::size_t>(observations[begin].track);
    std::size_t end = begin + 1;
    while (end < observations.size() && observations[end].track == observations[begin].track) {
      ++end;
    }
    if (geometry.known[track] != 0) {
      covariances[track] =
          point_covariance(observations, begin, end, geometry.points_T[track], *workspace, fix);
    }
    begin = end;
  }
  return true;
}

bool normalise_gauge(const InitialGeometryView& g) {
  const std::size_t first = first_posed(g);
  if (first == g.posed.size() || count_known(g.known) < kPointsMin) {
    return false;
  }
  const Eigen::Matrix3d R_NT = nearest_rotation(g.poses[first].R_CT);  // N: the new axes
  const Eigen::Vector3d centre = median_point(g, R_NT);
  const double extent = robust_extent(g, centre);
  if (!(extent > 0.0) || !std::isfinite(extent)) {
    return false;
  }
  FixedVector<InverseDepthPose, limits::kInitialFrames> poses;
  for (std::size_t f = 0; f < g.poses.size(); ++f) {
    const Pose pose = from_inverse_depth(g.poses[f]);
    const Pose moved{.R_CT = nearest_rotation(pose.R_CT * R_NT.transpose()),
                     .p_CT = pose.to_camera(centre) / extent};
    if (g.posed[f] != 0 && !is_before_camera(moved)) {
      return false;
    }
    (void)poses.push_back(g.posed[f] != 0 ? to_inverse_depth(moved) : g.poses[f]);
  }
  std::copy(poses.begin(), poses.end(), g.poses.begin());
  for (std::size_t i = 0; i < g.points_T.size(); ++i) {
    g.points_T[i] = R_NT * (g.points_T[i] - centre) / extent;
  }
  return true;
}

void apply_depth_reversal(const InitialGeometryView& g) {
  const Eigen::Vector3d flip(1.0, 1.0, -1.0);
  for (std::size_t f = 0; f < g.poses.size(); ++f) {
    if (g.posed[f] == 0) {
      continue;
    }
    // Seen along the line of sight to T's origin, depth is the third axis.
    const Eigen::Vector3d direction(g.poses[f].uvs.x(), g.poses[f].uvs.y(), 1.0);
    const Eigen::Matrix3d R_SC =
        Eigen::Quaterniond::FromTwoVectors(direction, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    g.poses[f].R_CT =
        R_SC.transpose() * flip.asDiagonal() * R_SC * g.poses[f].R_CT * flip.asDiagonal();
  }
  for (Eigen::Vector3d& p_T : g.points_T) {
    p_T = flip.asDiagonal() * p_T;
  }
}

}  // namespace polhode
