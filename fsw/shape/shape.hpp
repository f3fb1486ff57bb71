// The target's shape from its landmarks: denoised cloud, planes, cylinder, completion, centre, body
// frame, dimensions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "base/result.hpp"
#include "shape/cloud.hpp"
#include "shape/completion.hpp"
#include "shape/cylinder.hpp"
#include "shape/options.hpp"
#include "shape/planes.hpp"
#include "shape/target_frame.hpp"

namespace polhode {

/// Basis of a length along a body axis.
enum class DimensionBasis : std::uint8_t {
  kNothing = 0,  ///< the points are flat there: the body's depth behind them is unknown
  kPoints = 1,   ///< the ends of the points: a lower bound
  kSurfaces = 2  ///< surfaces found at both ends, or the cylinder's diameter
};

/// Lengths in the unit of the landmarks (map units until the scale is known).
struct Shape {
  double spacing = 0.0;               ///< typical distance of neighbouring landmarks
  double thickness = 0.0;             ///< 1-sigma noise of the cloud across its surface
  std::size_t landmarks = 0;          ///< number of input landmarks
  std::size_t cloud_points = 0;       ///< measured, after denoising
  std::size_t completion_points = 0;  ///< added
  CompletionKind completion = CompletionKind::kNone;
  Eigen::Vector3d centroid_measured_T = Eigen::Vector3d::Zero();  ///< mean of the denoised cloud
  Eigen::Vector3d centroid_T =
      Eigen::Vector3d::Zero();  ///< centre of the completed body, else the same
  TargetFrame frame;            ///< axes B in T
  Eigen::Vector3d dimensions = Eigen::Vector3d::Zero();        ///< full lengths along B's axes
  Eigen::Vector3d sigma_dimensions = Eigen::Vector3d::Zero();  ///< 1-sigma
  std::array<DimensionBasis, 3> dimension_basis{};
  Planes planes;
  std::optional<Cylinder> cylinder;
  std::optional<Box> box;
};

/// Workspace of a shape estimate, and the cloud that results. Owned by the caller: 2 MB.
struct ShapeWork {
  Cloud cloud;  ///< denoised; points from cloud.measured on were added
  CloudScratch scratch;
  SurfaceNormals normals;
  PlaneOwners owners;  ///< plane of each measured point, -1: none, kOnCylinder
};
/// Above every number of a plane.
inline constexpr std::int8_t kOnCylinder = 127;

/// @param landmarks_T  at most limits::kCloudPoints are used; non-finite ones are left out.
/// @param previous     the last estimate in the same T, for the names of the axes; null at first.
/// @errors TooFewObservations (under 5 landmarks, or nothing left but noise), Degenerate (points
/// coincide). Planes, a cylinder or a box that cannot be found are absent from the result, which is
/// no error.
/// @cost   dominated by plane_iterations_max times the cloud's points, for each plane, twice.
/// Deterministic in (landmarks, options, seed, previous).
Result<Shape> estimate_shape(std::span<const Eigen::Vector3d> landmarks_T,
                             const ShapeOptions& options,
                             std::uint64_t seed,
                             const Shape* previous,
                             ShapeWork& work);

}  // namespace polhode
