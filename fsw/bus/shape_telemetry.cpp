#include "bus/shape_telemetry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bus/narrow.hpp"
#include "bus/packet_layout.hpp"

namespace polhode::bus {
namespace {

static_assert(std::tuple_size_v<decltype(ShapePacket::plane_offset)> == limits::kPlanes);

template <std::size_t kCount, typename Vector>
void put_row(const Vector& v, std::size_t row, std::array<float, kCount>* out) {
  const auto width = static_cast<std::size_t>(v.size());
  for (std::size_t i = 0; i < width; ++i) {
    (*out)[row * width + i] = static_cast<float>(v[static_cast<Eigen::Index>(i)]);
  }
}

void put_planes(const Planes& planes, double unit, ShapePacket* packet) {
  packet->plane_count = static_cast<std::uint8_t>(planes.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Plane& plane = planes[i];
    const Eigen::Vector3d variance = plane.covariance.diagonal().cwiseMax(0.0);
    const Eigen::Vector3d sigma(
        std::sqrt(variance[0]), std::sqrt(variance[1]), unit * std::sqrt(variance[2]));
    put_row(plane.normal_T, i, &packet->plane_normal_T);
    put_row(Eigen::Vector3d(unit * plane.centre_T), i, &packet->plane_centre_T);
    put_row(Eigen::Vector2d(unit * plane.extents), i, &packet->plane_extent);
    put_row(sigma, i, &packet->plane_sigma);
    packet->plane_offset[i] = static_cast<float>(unit * plane.offset);
    packet->plane_inliers[i] = clipped(plane.inliers);
  }
}

/// The axes determined by the body's geometry, and the basis of each dimension.
void put_axes(const Shape& shape, ShapePacket* packet) {
  constexpr std::array<std::uint8_t, 3> kFlags{
      shape_layout::kFlagAxisX, shape_layout::kFlagAxisY, shape_layout::kFlagAxisZ};
  for (std::size_t k = 0; k < 3; ++k) {
    packet->flags |= shape.frame.axes_known[k] ? kFlags[k] : std::uint8_t{0};
    packet->dimension_basis[k] = static_cast<std::uint8_t>(shape.dimension_basis[k]);
  }
}

void put_cylinder(const Cylinder& cylinder, double unit, ShapePacket* packet) {
  packet->flags |= shape_layout::kFlagCylinder;
  put_row(cylinder.axis_T, 0, &packet->cylinder_axis_T);
  put_row(Eigen::Vector3d(unit * cylinder.centre_T), 0, &packet->cylinder_centre_T);
  packet->cylinder_radius = static_cast<float>(unit * cylinder.radius);
  packet->cylinder_length = static_cast<float>(unit * cylinder.length);
  packet->cylinder_coverage_rad = static_cast<float>(cylinder.coverage_rad);
  packet->sigma_cylinder_axis_rad = static_cast<float>(cylinder.sigma_axis_rad);
  packet->sigma_cylinder_radius = static_cast<float>(unit * cylinder.sigma_radius);
}

}  // namespace

std::array<double, 4> quaternion_of(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) {
    q.coeffs() *= -1.0;
  }
  return {q.w(), q.x(), q.y(), q.z()};
}

ShapePacket to_packet(const Shape& shape, const LengthUnit& unit) {
  const double scale = unit.metres_per_mu;
  ShapePacket packet;
  packet.flags = shape_layout::kFlagShape;
  packet.q_TB = quaternion_of(shape.frame.R_TB);
  packet.centroid_T = to_array(scale * shape.centroid_T);
  packet.centroid_measured_T = to_array(scale * shape.centroid_measured_T);
  packet.dimensions = to_array(scale * shape.dimensions);
  packet.sigma_dimensions = to_array(scale * shape.sigma_dimensions);
  packet.spacing = static_cast<float>(scale * shape.spacing);
  packet.thickness = static_cast<float>(scale * shape.thickness);
  packet.landmarks = clipped(shape.landmarks);
  packet.cloud_points = clipped(shape.cloud_points);
  packet.completion_points = clipped(shape.completion_points);
  packet.completion = static_cast<std::uint8_t>(shape.completion);
  packet.frame_source = static_cast<std::uint8_t>(shape.frame.source);
  put_axes(shape, &packet);
  if (unit.known) {
    packet.flags |= shape_layout::kFlagScaleKnown;
    packet.metres_per_mu = scale;
    packet.sigma_scale = static_cast<float>(unit.relative_sigma);
  }
  put_planes(shape.planes, scale, &packet);
  if (shape.cylinder) {
    put_cylinder(*shape.cylinder, scale, &packet);
  }
  return packet;
}

}  // namespace polhode::bus
