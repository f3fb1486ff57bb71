#include "shape/shape.hpp"

#include <algorithm>
#include <cmath>

#include "shape/rectangle.hpp"
#include "shape/rounded.hpp"

namespace polhode {
namespace {

// Band of a surface's points. Half a spacing: where the cloud resolves the surface, heights of
// neighbours differ by less. Or 2.5 sigma of the noise, which covers 98.8 % of a normal one.
constexpr double kBand_spacings = 0.5;
constexpr double kBand_thicknesses = 2.5;
// A box or a cylinder explains points a little farther off: edges are round, faces not quite
// parallel. Chosen: one spacing and one sigma more than the band.
constexpr double kTolerance_spacings = kBand_spacings + 1.0;
constexpr double kTolerance_thicknesses = kBand_thicknesses + 1.0;
// Chosen: three fix a plane, seven more make a chance plane rare.
constexpr std::size_t kPlanePointsMin = 10;
// A cylinder has two parameters more than a plane and replaces several planes. So it must have a
// third of all points. Chosen.
constexpr double kCylinderPart = 0.33;
// It must have nearly as many points as the planes that it replaces. Chosen; larger leaves round
// bodies as prisms, smaller makes boxes round.
constexpr double kCylinderOverPlanes = 0.9;
// The bend of a map moves its surfaces by about this part of the noise, however many points they
// have. On rendered bodies lengths between surfaces are off by 1 to 2 % at a noise of 3 %
// (decision 0054).
constexpr double kBent_thicknesses = 0.5;
// Random points have a pitch (one point per pitch^2) of two spacings. Holes in a found surface
// widen it by a factor of two at most.
constexpr double kPitchMax_spacings = 4.0;

void reset_owners(std::size_t count, PlaneOwners& owners) {
  owners.clear();
  for (std::size_t i = 0; i < count; ++i) {
    POLHODE_ASSERT(owners.push_back(-1), i);
  }
}

double tolerance_of(const Shape& shape) {
  return std::max(kTolerance_spacings * shape.spacing, kTolerance_thicknesses * shape.thickness);
}

PlaneSearch plane_search(const ShapeOptions& options,
                         std::uint64_t seed,
                         const Shape& shape,
                         std::size_t points) {
  const double part = options.plane_inlier_min * static_cast<double>(points);
  return {
      .distance_max = std::max(kBand_spacings * shape.spacing, kBand_thicknesses * shape.thickness),
      .inliers_min = std::max(kPlanePointsMin, static_cast<std::size_t>(std::ceil(part))),
      .iterations_max = options.plane_iterations_max,
      .seed = seed};
}

/// Points on the planes along the axis, which a cylinder would replace, less those beside each: a
/// slab cut out of a thick cloud counts little.
double worth_of_faces(const Planes& planes, const Cylinder& cylinder) {
  double sum = 0.0;
  for (const Plane& plane : planes) {
    if (std::abs(plane.normal_T.dot(cylinder.axis_T)) <= kOrthogonalCosineMax) {
      sum += static_cast<double>(plane.inliers) - static_cast<double>(plane.beside);
    }
  }
  return sum;
}

double worth_of(const Cylinder& cylinder) {
  return static_cast<double>(cylinder.inliers) - static_cast<double>(cylinder.beside);
}

/// A cylinder where it explains the cloud better than planes and an ellipsoid do. Planes are then
/// searched for among the other points.
void find_surfaces(const ShapeOptions& options, std::uint64_t seed, Shape& shape, ShapeWork& work) {
  const std::span<const Eigen::Vector3d> points_T = work.cloud.points_T.view();
  shape.thickness =
      estimate_normals_by_spacing(points_T, shape.spacing, work.scratch, work.normals);
  const PlaneSearch search = plane_search(options, seed, shape, points_T.size());
  reset_owners(points_T.size(), work.owners);
  find_planes(points_T, work.normals, search, work.owners, shape.planes);
  const CylinderSearch round{
      .distance_max = search.distance_max,
      .inliers_min =
          std::max(kPlanePointsMin,
                   static_cast<std::size_t>(kCylinderPart * static_cast<double>(points_T.size()))),
      .iterations_max = options.plane_iterations_max,
      .seed = seed};
  const Result<Cylinder> cylinder = find_cylinder(points_T, work.normals, round);
  if (!cylinder ||
      worth_of(cylinder.value()) <
          kCylinderOverPlanes * worth_of_faces(shape.planes, cylinder.value()) ||
      is_rounded(points_T, cylinder.value(), search.distance_max)) {
    return;
  }
  shape.cylinder = cylinder.value();
  shape.cylinder->sigma_radius =
      std::hypot(shape.cylinder->sigma_radius, kBent_thicknesses * shape.thickness);
  reset_owners(points_T.size(), work.owners);
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    const Eigen::Vector3d apart = points_T[i] - shape.cylinder->centre_T;
    if (std::abs(shape.cylinder->distance(points_T[i])) <= search.distance_max &&
        std::abs(shape.cylinder->axis_T.dot(apart)) <= 0.5 * shape.cylinder->length) {
      work.owners[i] = kOnCylinder;
    }
  }
  find_planes(points_T, work.normals, search, work.owners, shape.planes);
  shape.cylinder->ends_found = snap_ends(shape.planes, *shape.cylinder);
}

/// Pitch of evenly spread points on the best measured surface.
double pitch_of(const Shape& shape) {
  double area = 0.0;
  std::size_t points = 0;
  if (shape.cylinder) {
    area = shape.cylinder->coverage_rad * shape.cylinder->radius * shape.cylinder->length;
    points = shape.cylinder->inliers;
  } else if (!shape.planes.empty()) {
    area = shape.planes[0].extents.prod();
    points = shape.planes[0].inliers;
  }
  const double pitch = points > 0 ? std::sqrt(area / static_cast<double>(points)) : 0.0;
  return std::clamp(pitch, shape.spacing, kPitchMax_spacings * shape.spacing);
}

Extent extent_along(const ShapeWork& work, const Eigen::Vector3d& direction_T) {
  FixedVector<double, limits::kCloudPoints> along;
  for (const Eigen::Vector3d& point_T : work.cloud.points_T.view().first(work.cloud.measured)) {
    POLHODE_ASSERT(along.push_back(direction_T.dot(point_T)), along.size());
  }
  return robust_extent(along.view());
}

/// Whether points lie beyond the cylinder's ends.
/// @param extent  of the points along its axis.
bool reaches_beyond(const Extent& extent, const Shape& shape) {
  return extent.most - extent.least > shape.cylinder->length + 2.0 * tolerance_of(shape);
}

void complete(Shape& shape, ShapeWork& work) {
  if (shape.cylinder) {
    if (explained_by(*shape.cylinder, work.cloud, tolerance_of(shape)) >= kExplainedMin) {
      shape.completion = CompletionKind::kCylinder;
      shape.completion_points = complete_cylinder(*shape.cylinder, pitch_of(shape), work.cloud);
      shape.centroid_T = shape.cylinder->centre_T;
      // Middle along the axis: that of the points, where a nozzle or an adapter extends beyond the
      // cylinder.
      const Extent extent = extent_along(work, shape.cylinder->axis_T);
      if (reaches_beyond(extent, shape)) {
        const double at = shape.cylinder->axis_T.dot(shape.centroid_T);
        shape.centroid_T += (0.5 * (extent.least + extent.most) - at) * shape.cylinder->axis_T;
      }
    }
    return;
  }
  const Result<Box> box = find_box(work.cloud, shape.planes, shape.spacing, tolerance_of(shape));
  if (box) {
    shape.box = box.value();
    shape.completion = CompletionKind::kBox;
    shape.completion_points = complete_box(*shape.box, pitch_of(shape), work.cloud);
    // The mean of evenly spread points, so that their density has no effect.
    shape.centroid_T = shape.box->centre_T;
  }
}

TargetFrame frame_of(const Shape& shape, const ShapeWork& work, const Shape* previous) {
  TargetFrame frame;
  if (shape.cylinder) {
    frame = frame_from_cylinder(*shape.cylinder, shape.planes);
  } else if (!shape.planes.empty()) {
    frame = frame_from_planes(shape.planes);
  } else {
    frame = frame_from_points(work.cloud.points_T.view().first(work.cloud.measured));
  }
  return previous != nullptr ? relabel_like(frame, previous->frame) : frame;
}

// Points this flat do not determine a length. Chosen: a spacing and 2.5 sigma of the noise at
// either end.
constexpr double kFlat_spacings = 2.0;
constexpr double kFlat_thicknesses = 2.0 * kBand_thicknesses;

void measure_points(const ShapeWork& work, Shape& shape) {
  const double flat = kFlat_spacings * shape.spacing + kFlat_thicknesses * shape.thickness;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Extent extent = extent_along(work, shape.frame.R_TB.col(k));
    shape.dimensions(k) = extent.most - extent.least;
    // The spacing of points at the ends, and the noise.
    shape.sigma_dimensions(k) = shape.spacing + shape.thickness;
    shape.dimension_basis[static_cast<std::size_t>(k)] =
        shape.dimensions(k) > flat ? DimensionBasis::kPoints : DimensionBasis::kNothing;
  }
}

void measure_box(Shape& shape) {
  const double bent = kBent_thicknesses * shape.thickness;
  for (Eigen::Index k = 0; k < 3; ++k) {
    Eigen::Index same = 0;  // the box's axis along B's axis k, in either direction
    (shape.box->R_TB.transpose() * shape.frame.R_TB.col(k)).cwiseAbs().maxCoeff(&same);
    shape.dimensions(k) = shape.box->dimensions(same);
    shape.sigma_dimensions(k) = std::hypot(shape.box->sigma_dimensions(same), bent);
    const auto face = 2 * static_cast<std::size_t>(same);
    shape.dimension_basis[static_cast<std::size_t>(k)] =
        shape.box->face_found[face] && shape.box->face_found[face + 1] ? DimensionBasis::kSurfaces
                                                                       : DimensionBasis::kPoints;
  }
}

void measure_cylinder(Shape& shape) {
  Eigen::Index along = 0;
  (shape.frame.R_TB.transpose() * shape.cylinder->axis_T).cwiseAbs().maxCoeff(&along);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (k == along) {
      if (shape.dimensions(k) > shape.cylinder->length + 2.0 * tolerance_of(shape)) {
        continue;  // points lie beyond the cylinder
      }
      shape.dimensions(k) = shape.cylinder->length;
      shape.dimension_basis[at] =
          shape.cylinder->ends_found == 2 ? DimensionBasis::kSurfaces : DimensionBasis::kPoints;
    } else {
      shape.dimensions(k) = 2.0 * shape.cylinder->radius;
      shape.sigma_dimensions(k) = 2.0 * shape.cylinder->sigma_radius;
      shape.dimension_basis[at] = DimensionBasis::kSurfaces;
    }
  }
}

/// Lengths along B: of the box or the cylinder where there is one, else of the measured points.
void measure(const ShapeWork& work, Shape& shape) {
  measure_points(work, shape);
  if (shape.completion == CompletionKind::kBox) {
    measure_box(shape);
  } else if (shape.completion == CompletionKind::kCylinder) {
    measure_cylinder(shape);
  }
}

}  // namespace

Result<Shape> estimate_shape(std::span<const Eigen::Vector3d> landmarks_T,
                             const ShapeOptions& options,
                             std::uint64_t seed,
                             const Shape* previous,
                             ShapeWork& work) {
  Shape shape;
  shape.landmarks = landmarks_T.size();
  const Result<double> spacing = denoise(landmarks_T, options, work.scratch, work.cloud);
  if (!spacing) {
    return spacing.error();
  }
  shape.spacing = spacing.value();
  shape.cloud_points = work.cloud.measured;
  shape.centroid_measured_T = centroid_T(work.cloud.points_T.view());
  shape.centroid_T = shape.centroid_measured_T;
  find_surfaces(options, seed, shape, work);
  shape.frame = frame_of(shape, work, previous);
  complete(shape, work);
  measure(work, shape);
  return shape;
}

}  // namespace polhode
