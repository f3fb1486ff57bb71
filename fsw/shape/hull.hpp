// The body's coarse surface: the convex hull of its cloud.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "base/result.hpp"
#include "config/limits.hpp"
#include "shape/cloud.hpp"

namespace polhode {

/// A closed convex surface.
struct Hull {
  /// A sphere of 500 corners is accurate to 0.4 % of its size. By Euler's formula a closed surface
  /// of triangles has twice as many faces, less four.
  static constexpr std::size_t kVertices = 500;
  static constexpr std::size_t kFaces = 2 * kVertices - 4;
  using Face = std::array<std::uint16_t, 3>;  ///< corners, anticlockwise as seen from outside

  FixedVector<Eigen::Vector3d, kVertices> vertices_T;
  FixedVector<Face, kFaces> faces;
  double volume = 0.0;
  double area = 0.0;
  double outside = 0.0;  ///< largest distance of a point beyond a face
};

/// Workspace of a hull. Owned by the caller: 0.2 MB.
struct HullWork {
  struct Facet {
    Hull::Face corners{};  // into the points
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double offset = 0.0;
    bool used = false;
    bool visible = false;
  };
  struct Edge {
    std::uint16_t from = 0;
    std::uint16_t to = 0;
  };
  static constexpr std::size_t kNoFacet = Hull::kFaces;

  std::array<Facet, Hull::kFaces> facets{};
  std::size_t facets_used = 0;
  FixedVector<std::uint16_t, limits::kCloudPoints> outside_of;  ///< facet that a point lies beyond
  FixedVector<double, limits::kCloudPoints> beyond;             ///< and how far
  FixedVector<Edge, 3 * Hull::kFaces> edges;
  FixedVector<std::uint16_t, Hull::kFaces> fresh;  ///< facets of the newest corner
};

/// Convex hull by quickhull: the point farthest beyond its face becomes a corner. Ends when no
/// point is farther out than `tolerance` or the tables are full, so that the omitted points change
/// the surface least.
/// @param tolerance  > 0: the resolution of the cloud.
/// @errors TooFewObservations (under 4 points), Degenerate (all points within `tolerance` of a
/// plane, a line or a point).
/// @cost   at most Hull::kVertices times the points and the faces. Deterministic.
/// @source Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", 1996.
Result<Hull> convex_hull(std::span<const Eigen::Vector3d> points_T,
                         double tolerance,
                         HullWork& work);

}  // namespace polhode
