#include "shape/target_frame.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

/// Mean direction of all planes parallel to `reference`, signs aligned with it, weighted by points.
Eigen::Vector3d shared_direction(const Planes& planes, const Eigen::Vector3d& reference) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Plane& plane : planes) {
    const double cosine = plane.normal_T.dot(reference);
    if (std::abs(cosine) >= kParallelCosineMin) {
      sum += std::copysign(static_cast<double>(plane.inliers), cosine) * plane.normal_T;
    }
  }
  return sum.norm() > 0.0 ? Eigen::Vector3d(sum.normalized()) : reference;
}

/// Direction across x: the normal of an orthogonal plane, else of an oblique one, else the long
/// edge of the first plane. `known`: false where it is arbitrary, as on a single square face.
Eigen::Vector3d second_direction(const Planes& planes, const Eigen::Vector3d& x_T, bool* known) {
  // Ratio from which the longer edge is distinct. Chosen: ends of rectangles are off by some per
  // cent.
  constexpr double kLongerEdgeMin = 1.1;
  // cos 30 deg: for a normal nearer to x the noise of the direction across x doubles.
  constexpr double kUsableCosineMax = 0.866;
  const Plane* oblique = nullptr;
  for (const Plane& plane : planes) {
    const double cosine = std::abs(plane.normal_T.dot(x_T));
    if (cosine <= kOrthogonalCosineMax) {
      *known = true;
      return shared_direction(planes, plane.normal_T);
    }
    if (cosine <= kUsableCosineMax && oblique == nullptr) {
      oblique = &plane;
    }
  }
  *known = oblique != nullptr || planes[0].extents.x() > kLongerEdgeMin * planes[0].extents.y();
  return oblique != nullptr ? oblique->normal_T : Eigen::Vector3d(planes[0].axes_T.col(0));
}

Eigen::Vector3d part_across(const Eigen::Vector3d& direction, const Eigen::Vector3d& axis) {
  return direction - axis * axis.dot(direction);
}

Eigen::Matrix3d from_z_and_x(const Eigen::Vector3d& z_T, const Eigen::Vector3d& x_like_T) {
  Eigen::Matrix3d R_TB;
  R_TB.col(2) = z_T;
  R_TB.col(0) = part_across(x_like_T, z_T).normalized();
  R_TB.col(1) = R_TB.col(2).cross(R_TB.col(0));
  return R_TB;
}

TargetFrame relabel_box(const TargetFrame& frame, const Eigen::Matrix3d& previous) {
  constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  const Eigen::Matrix3d& R_TB = frame.R_TB;
  TargetFrame best = frame;
  double trace_best = -std::numeric_limits<double>::infinity();
  for (const auto& order : kOrders) {
    for (int signs = 0; signs < 4; ++signs) {
      Eigen::Matrix3d candidate;
      candidate.col(0) = (signs & 1) != 0 ? Eigen::Vector3d(-R_TB.col(order[0]))
                                          : Eigen::Vector3d(R_TB.col(order[0]));
      candidate.col(1) = (signs & 2) != 0 ? Eigen::Vector3d(-R_TB.col(order[1]))
                                          : Eigen::Vector3d(R_TB.col(order[1]));
      candidate.col(2) = candidate.col(0).cross(candidate.col(1));
      const double trace = (candidate.transpose() * previous).trace();
      if (trace > trace_best) {
        trace_best = trace;
        best.R_TB = candidate;
        for (std::size_t k = 0; k < 3; ++k) {
          best.axes_known[k] = frame.axes_known[static_cast<std::size_t>(order[k])];
        }
      }
    }
  }
  return best;
}

}  // namespace

TargetFrame frame_from_planes(const Planes& planes) {
  POLHODE_ASSERT(!planes.empty(), planes.size());
  const Eigen::Vector3d x_T = shared_direction(planes, planes[0].normal_T);
  Eigen::Matrix3d rough;
  rough.col(0) = x_T;
  bool across_known = false;
  rough.col(1) = second_direction(planes, x_T, &across_known);
  rough.col(1) = part_across(rough.col(1), x_T).normalized();
  rough.col(2) = rough.col(0).cross(rough.col(1));
  // With a third family of planes: the rotation nearest to all three directions.
  for (const Plane& plane : planes) {
    if (std::abs(plane.normal_T.dot(rough.col(2))) >= kParallelCosineMin) {
      const Eigen::Vector3d third = shared_direction(planes, plane.normal_T);
      rough.col(2) = third.dot(rough.col(2)) < 0.0 ? Eigen::Vector3d(-third) : third;
      break;
    }
  }
  return {.R_TB = nearest_rotation(rough),
          .source = FrameSource::kPlanes,
          .axes_known = {true, across_known, across_known}};
}

TargetFrame frame_from_cylinder(const Cylinder& cylinder, const Planes& planes) {
  Eigen::Vector3d x_like_T = Eigen::Vector3d::Zero();
  for (const Plane& plane : planes) {
    if (std::abs(plane.normal_T.dot(cylinder.axis_T)) <= kOrthogonalCosineMax) {
      x_like_T = plane.normal_T;
      break;
    }
  }
  const bool across_known = !x_like_T.isZero();
  if (!across_known) {
    Eigen::Index most_across = 0;
    cylinder.axis_T.cwiseAbs().minCoeff(&most_across);
    x_like_T = Eigen::Vector3d::Unit(most_across);
  }
  return {.R_TB = from_z_and_x(cylinder.axis_T, x_like_T),
          .source = FrameSource::kCylinder,
          .axes_known = {across_known, across_known, true}};
}

TargetFrame frame_from_points(std::span<const Eigen::Vector3d> points_T) {
  const Eigen::Vector3d mean_T = centroid_T(points_T);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point_T : points_T) {
    scatter += (point_T - mean_T) * (point_T - mean_T).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  TargetFrame frame;
  frame.R_TB.col(0) = eigen.eigenvectors().col(2);
  frame.R_TB.col(1) = eigen.eigenvectors().col(1);
  frame.R_TB.col(2) = frame.R_TB.col(0).cross(frame.R_TB.col(1));
  // Ratio of eigenvalues from which axes are distinct. Chosen; with nearer ones the order depends
  // on the choice of points.
  constexpr double kSpreadRatioMin = 1.3;
  const Eigen::Vector3d spread = eigen.eigenvalues().reverse().cwiseMax(0.0);
  const bool first = spread(0) > kSpreadRatioMin * spread(1);
  // Least spread across a line of points, in parts of its length, squared: less is rounding.
  constexpr double kLineSpread = 1e-6;
  const bool last = spread(1) > kSpreadRatioMin * spread(2) && spread(1) > kLineSpread * spread(0);
  frame.axes_known = {first, first && last, last};
  return frame;
}

TargetFrame relabel_like(const TargetFrame& frame, const TargetFrame& previous) {
  if (frame.source != FrameSource::kCylinder || frame.axes_known[0]) {
    return relabel_box(frame, previous.R_TB);
  }
  const Eigen::Vector3d axis_T = frame.R_TB.col(2);
  Eigen::Index name = 0;
  (previous.R_TB.transpose() * axis_T).cwiseAbs().maxCoeff(&name);
  const Eigen::Index next = (name + 1) % 3;
  const Eigen::Vector3d along_T =
      axis_T.dot(previous.R_TB.col(name)) < 0.0 ? Eigen::Vector3d(-axis_T) : axis_T;
  TargetFrame out{.source = FrameSource::kCylinder};
  const Eigen::Matrix3d R = from_z_and_x(along_T, previous.R_TB.col(next));
  out.R_TB.col(name) = R.col(2);
  out.R_TB.col(next) = R.col(0);
  out.R_TB.col((name + 2) % 3) = R.col(1);
  out.axes_known[static_cast<std::size_t>(name)] = true;
  return out;
}

}  // namespace polhode
