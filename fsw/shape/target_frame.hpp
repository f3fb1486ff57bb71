// The body frame B: axes from the target's own geometry, right-handed, and stable from update to
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
  kPrincipal = 0,  ///< principal axes of the cloud: no plane or cylinder was found
  kPlanes = 1,     ///< x along the strongest plane's normal, y along the component of the next
                   ///< one's across it
  kCylinder = 2,   ///< z along the cylinder's axis
};

struct TargetFrame {
  Eigen::Matrix3d R_TB = Eigen::Matrix3d::Identity();  ///< takes B components to T components
  FrameSource source = FrameSource::kPrincipal;
  /// Axes that the body's geometry determines. The others are arbitrary: a ball has none, a smooth
  /// cylinder one.
  std::array<bool, 3> axes_known{};
};

/// Cosines of 10 deg and of 80 deg: directions count as parallel or orthogonal within 10 deg.
/// Chosen: normals of planes are good to a few degrees, and panels lean by more.
inline constexpr double kParallelCosineMin = 0.985;
inline constexpr double kOrthogonalCosineMax = 0.174;

/// Axes from planes, the one with most points first. Parallel planes share a direction, weighted by
/// their points. A single plane takes y from its rectangle's long edge. `planes` must not be empty.
TargetFrame frame_from_planes(const Planes& planes);

/// z along the axis; x along the first plane's normal that lies across it, else the T axis most
/// across it.
TargetFrame frame_from_cylinder(const Cylinder& cylinder, const Planes& planes);

/// x along the largest spread, z along the least.
TargetFrame frame_from_points(std::span<const Eigen::Vector3d> points_T);

/// Names the axes as in `previous`: takes the nearest of the 24 right-handed relabellings of a
/// box's axes. A round body leaves the rotation about its axis undetermined. Its axis keeps the
/// name of the nearest previous axis, and the other two stay as near to the previous ones as they
/// can.
TargetFrame relabel_like(const TargetFrame& frame, const TargetFrame& previous);

}  // namespace polhode
