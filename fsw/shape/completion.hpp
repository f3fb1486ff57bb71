// Completion: fills unseen and broken faces with points of the cloud's own density. The centroid of
// the complete body is nearer to its geometric centre than that of the faces that were seen.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/result.hpp"
#include "shape/cloud.hpp"
#include "shape/cylinder.hpp"
#include "shape/planes.hpp"
#include "shape/target_frame.hpp"

namespace polhode {

// Least part of the points that a box or a cylinder must explain; dents and small attachments are
// the rest. Chosen: lower makes a box out of panels, higher refuses bodies with attachments.
inline constexpr double kExplainedMin = 0.7;

enum class CompletionKind : std::uint8_t { kNone = 0, kBox = 1, kCylinder = 2 };

/// The body as a box along B's axes; lengths in the cloud's unit.
struct Box {
  Eigen::Matrix3d R_TB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();
  Eigen::Vector3d dimensions = Eigen::Vector3d::Zero();  ///< full lengths along B's axes
  Eigen::Vector3d sigma_dimensions = Eigen::Vector3d::Zero();
  std::array<bool, 6> face_found{};  ///< by a plane: -x, +x, -y, +y, -z, +z of B
  double explained = 0.0;            ///< part of the points within the band of its surface
};

/// Box from planes; two must be orthogonal. A face without a plane ends where the points end.
/// @param tolerance  points this near to the box's surface are explained by it.
/// @errors Degenerate (no two orthogonal planes), NoConsensus (too few points lie on
/// the box: it is another body, or carries panels).
Result<Box> find_box(const Cloud& cloud, const Planes& planes, double spacing, double tolerance);

/// Moves the cylinder's ends to flat ends found across its axis near them. Points at the edges of
/// the ends lie on the round surface too, and make it look longer.
/// @return number of ends found, 0 .. 2.
int snap_ends(const Planes& planes, Cylinder& cylinder);

/// Adds points on the box's faces where the cloud has none near. Stops where the table is full.
/// @param pitch  distance of added points from each other: 1 / sqrt(points per area) of the
/// measured faces.
/// @return number added.
std::size_t complete_box(const Box& box, double pitch, Cloud& cloud);

/// As above for the cylinder: its round surface, and both ends where one of them was found.
std::size_t complete_cylinder(const Cylinder& cylinder, double pitch, Cloud& cloud);

/// Part of the measured points within `tolerance` of the cylinder's round surface or ends.
double explained_by(const Cylinder& cylinder, const Cloud& cloud, double tolerance);

}  // namespace polhode
