// The body frame B: axes from the target's own geometry, right-handed, and the same ones at each
// update.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "shape/cylinder.hpp"
#include "shape/planes.hpp"

namespace polhode {

enum class FrameSource : std::uint8_t {
  kPrincipal = 0,  ///< principal axes of the cloud: nothing flat or round was found
  kPlanes = 1,     ///< x along the strongest plane's normal, y along the next one's part across it
  kCylinder = 2,   ///< z along the cylinder's axis
};

struct TargetFrame {
  Eigen::Matrix3d R_TB = Eigen::Matrix3d::Identity();  ///< takes B components to T components
  FrameSource source = FrameSource::kPrincipal;
  /// Axes that the body's geometry fixes; the others are a choice (a ball has none, a smooth
  /// cylinder one).
  std::array<bool, 3> axes_known{};
};

/// Directions within this of each other count as parallel, and of a right angle as orthogonal: 10
/// deg.
inline constexpr double kParallelCosineMin = 0.985;
inline constexpr double kOrthogonalCosineMax = 0.174;

/// Axes from planes, the one with most points first; parallel planes share a direction, weighted by
/// their points. A single plane takes y from its rectangle's long edge. `planes` must not be empty.
TargetFrame frame_from_planes(const Planes& planes);

/// z along the axis; x along the first plane's normal that lies across it, else the T axis most
/// across it.
TargetFrame frame_from_cylinder(const Cylinder& cylinder, const Planes& planes);

/// x along the largest spread, z along the least.
TargetFrame frame_from_points(std::span<const Eigen::Vector3d> points_T);

/// The same axes named as in `previous`: of the 24 right-handed relabellings of a box's axes the
/// nearest one. A round body leaves the turn about its axis open: the axis keeps the name that the
/// previous axis nearest to it has, and the other two stay where they were as far as they can.
TargetFrame relabel_like(const TargetFrame& frame, const TargetFrame& previous);

}  // namespace polhode
