// Broken and unseen sides, filled with points of the cloud's own density: the whole body's centre
// is nearer to the geometric centre than that of the sides that happen to be there.
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

/// Box from planes: needs two orthogonal ones. A side without a plane ends where the points do.
/// @param tolerance  points this near to the box's surface are explained by it.
/// @errors Degenerate (no two orthogonal planes), NoConsensus (over 30 % of the points lie off the
/// box: it is something
///         else, or carries panels, and completing it would make a body up).
Result<Box> find_box(const Cloud& cloud, const Planes& planes, double spacing, double tolerance);

/// Moves the cylinder's ends to the flat ends found across its axis near them: points of the ends'
/// rims lie on the round surface, too, and make it look longer.
/// @return number of ends found, 0 .. 2.
int snap_ends(const Planes& planes, Cylinder& cylinder);

/// Adds points on the box's sides wherever the cloud has none within 1.2 grid steps. Full tables
/// end it.
/// @param pitch  distance of added points from each other: 1 / sqrt(points per area) of the
/// measured sides.
/// @return number added.
std::size_t complete_box(const Box& box, double pitch, CloudScratch& scratch, Cloud& cloud);

/// As above, round surface and both ends.
std::size_t complete_cylinder(const Cylinder& cylinder,
                              double pitch,
                              CloudScratch& scratch,
                              Cloud& cloud);

/// Part of the measured points within `tolerance` of the cylinder's round surface or ends.
double explained_by(const Cylinder& cylinder, const Cloud& cloud, double tolerance);

}  // namespace polhode
