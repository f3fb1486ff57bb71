#include "app/cloud_details.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace polhode::platform {
namespace {

// Added points are on the end of a cylinder up to rounding.
constexpr double kOnEnd = 1.0 - 1e-6;

/// Landmarks of one cube.
struct Members {
  Eigen::Vector3d directions_T = Eigen::Vector3d::Zero();  ///< sum
  double variances = 0.0;                                  ///< sum
  std::int32_t views = 0;                                  ///< sum
  int count = 0;
};

using MembersByCube = std::map<std::array<std::int64_t, 3>, Members>;

MembersByCube members_by_cube(const ConfirmedLandmarks& landmarks, double edge) {
  MembersByCube found;
  for (std::size_t i = 0; i < landmarks.points_T.size(); ++i) {
    Members& members = found[cube_of(landmarks.points_T[i], edge)];
    members.directions_T += landmarks.directions_T[i];
    members.variances += landmarks.sigmas[i] * landmarks.sigmas[i];
    members.views += landmarks.views[i];
    ++members.count;
  }
  return found;
}

Eigen::Vector3d radial(const Cylinder& cylinder, const Eigen::Vector3d& point_T) {
  const Eigen::Vector3d apart = point_T - cylinder.centre_T;
  return (apart - cylinder.axis_T.dot(apart) * cylinder.axis_T).normalized();
}

/// Direction of the surface at a measured point, either sign; zero where undetermined.
Eigen::Vector3d direction_of(const Shape& shape, const ShapeWork& work, std::size_t i) {
  const std::int8_t owner = work.owners[i];
  if (owner == kOnCylinder) {
    return radial(*shape.cylinder, work.cloud.points_T[i]);
  }
  return owner >= 0 ? shape.planes[static_cast<std::size_t>(owner)].normal_T
                    : work.normals[i].normal_T;
}

Eigen::Vector3d turned_to(const Eigen::Vector3d& cameras_T, const Eigen::Vector3d& direction_T) {
  if (direction_T.isZero()) {
    return cameras_T.normalized();  // a lone point: it was seen from there
  }
  return direction_T.dot(cameras_T) < 0.0 ? Eigen::Vector3d(-direction_T) : direction_T;
}

/// Normal of the side of the box or cylinder that completion put a point on.
Eigen::Vector3d normal_of_side(const Shape& shape, const Eigen::Vector3d& point_T) {
  if (shape.completion == CompletionKind::kBox) {
    const Eigen::Vector3d p_B = shape.box->R_TB.transpose() * (point_T - shape.box->centre_T);
    Eigen::Index side = 0;
    p_B.cwiseQuotient(shape.box->dimensions).cwiseAbs().maxCoeff(&side);
    return std::copysign(1.0, p_B(side)) * shape.box->R_TB.col(side);
  }
  const Cylinder& cylinder = *shape.cylinder;
  const double height = cylinder.axis_T.dot(point_T - cylinder.centre_T);
  return std::abs(height) >= kOnEnd * 0.5 * cylinder.length
             ? Eigen::Vector3d(std::copysign(1.0, height) * cylinder.axis_T)
             : radial(cylinder, point_T);
}

double sigma_of(const Members& members, double thickness) {
  return members.count > 0 ? std::hypot(std::sqrt(members.variances) / members.count, thickness)
                           : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

CloudDetails details_of(const Shape& shape,
                        const ShapeWork& work,
                        const ConfirmedLandmarks& landmarks,
                        double edge) {
  const MembersByCube by_cube = members_by_cube(landmarks, edge);
  CloudDetails details;
  for (std::size_t i = 0; i < work.cloud.points_T.size(); ++i) {
    const Eigen::Vector3d& point_T = work.cloud.points_T[i];
    if (i >= work.cloud.measured) {
      details.normals_T.push_back(normal_of_side(shape, point_T));
      details.sigmas.push_back(std::numeric_limits<float>::quiet_NaN());
      details.views.push_back(0);
      continue;
    }
    const auto found = by_cube.find(cube_of(point_T, edge));
    // The mean of points in one cube is in it, but for rounding.
    const Members members = found == by_cube.end() ? Members{} : found->second;
    details.normals_T.push_back(turned_to(members.directions_T, direction_of(shape, work, i)));
    details.sigmas.push_back(static_cast<float>(sigma_of(members, shape.thickness)));
    details.views.push_back(members.views);
  }
  return details;
}

}  // namespace polhode::platform
