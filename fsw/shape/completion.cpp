#include "shape/completion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shape/rectangle.hpp"

namespace polhode {
namespace {

// Radius of a hole that is filled. Random points of one per squared pitch leave such a hole by
// chance in exp(-pi 1.2^2), 1 % of the places.
constexpr double kHole_pitches = 1.2;
// Bias of a plane, as a part of its rms: points of adjoining faces pull it inwards near the edges.
// Chosen; larger widens the sigmas of all lengths.
constexpr double kEdgePull = 0.2;
// Largest distance of a face's plane from the end of the points, in lengths of the body. Chosen;
// larger takes steps and recesses for faces, smaller misses faces with points of attachments beyond
// them.
constexpr double kFaceDepthMax = 0.1;
// Points end up to a whole spacing before the edge, half a spacing in the mean.
constexpr double kEndSigma_spacings = 0.5;
// A box thinner than two spacings is not resolved by its points.
constexpr double kBoxMin_spacings = 2.0;

struct Filler {
  PointTree measured;
  double pitch;
  Cloud& cloud;
  std::size_t added = 0;

  /// Adds a point where the measured cloud has none near. False when the table is full.
  bool offer(const Eigen::Vector3d& place_T) {
    if (measured.any_within(place_T, kHole_pitches * pitch)) {
      return true;
    }
    if (!cloud.points_T.push_back(place_T)) {
      return false;
    }
    ++added;
    return true;
  }
};

Filler start_filling(double pitch, Cloud& cloud) {
  POLHODE_ASSERT(pitch > 0.0, pitch);
  while (cloud.points_T.size() > cloud.measured) {
    cloud.points_T.pop_back();
  }
  return {.measured = PointTree(cloud.points_T.view()), .pitch = pitch, .cloud = cloud};
}

/// Number of cells of about `pitch` over a length, bounded by the table that they fill.
int cells(double length, double pitch) {
  return static_cast<int>(
      std::clamp(std::round(length / pitch), 1.0, static_cast<double>(limits::kCloudPoints)));
}

struct Face {
  double position = 0.0;  // along the axis
  double sigma = 0.0;
  bool found = false;
};

/// The box's face at one end of an axis: the plane with most points among those near that end.
/// Without one, the end of the points.
Face find_face(const Planes& planes,
               const Eigen::Vector3d& axis_T,
               const Extent& extent,
               double sign,
               double spacing) {
  const double end = sign > 0.0 ? extent.most : extent.least;
  const double depth_max = std::max(kFaceDepthMax * (extent.most - extent.least), spacing);
  Face face{.position = end, .sigma = kEndSigma_spacings * spacing};
  std::size_t inliers = 0;
  for (const Plane& plane : planes) {
    const double cosine = plane.normal_T.dot(axis_T);
    const double position = axis_T.dot(plane.centre_T);
    if (std::abs(cosine) >= kParallelCosineMin && std::abs(position - end) <= depth_max &&
        plane.inliers > inliers) {
      inliers = plane.inliers;
      face = {.position = position,
              .sigma = std::hypot(std::sqrt(plane.covariance(2, 2)), kEdgePull * plane.rms),
              .found = true};
    }
  }
  return face;
}

/// Distance of a point in box coordinates (from the centre) to the box's surface.
double surface_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& half) {
  const Eigen::Vector3d beyond = p.cwiseAbs() - half;
  const double inside = beyond.maxCoeff();
  return inside <= 0.0 ? -inside : beyond.cwiseMax(0.0).norm();
}

bool has_orthogonal_pair(const Planes& planes) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (std::abs(planes[i].normal_T.dot(planes[j].normal_T)) <= kOrthogonalCosineMax) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

Result<Box> find_box(const Cloud& cloud, const Planes& planes, double spacing, double tolerance) {
  if (planes.empty() || !has_orthogonal_pair(planes)) {
    return ErrorCode::kDegenerate;
  }
  Box box;
  box.R_TB = frame_from_planes(planes).R_TB;
  const std::span<const Eigen::Vector3d> measured_T = cloud.points_T.view().first(cloud.measured);
  Eigen::Vector3d centre_B;
  for (Eigen::Index k = 0; k < 3; ++k) {
    FixedVector<double, limits::kCloudPoints> along;
    for (const Eigen::Vector3d& point_T : measured_T) {
      POLHODE_ASSERT(along.push_back(box.R_TB.col(k).dot(point_T)), along.size());
    }
    const Extent extent = robust_extent(along.view());
    const Face low = find_face(planes, box.R_TB.col(k), extent, -1.0, spacing);
    const Face high = find_face(planes, box.R_TB.col(k), extent, 1.0, spacing);
    box.face_found[static_cast<std::size_t>(2 * k)] = low.found;
    box.face_found[static_cast<std::size_t>(2 * k + 1)] = high.found;
    centre_B(k) = 0.5 * (low.position + high.position);
    box.dimensions(k) = high.position - low.position;
    box.sigma_dimensions(k) = std::hypot(low.sigma, high.sigma);
  }
  box.centre_T = box.R_TB * centre_B;
  std::size_t near = 0;
  for (const Eigen::Vector3d& point_T : measured_T) {
    const Eigen::Vector3d p_B = box.R_TB.transpose() * (point_T - box.centre_T);
    near += surface_distance(p_B, 0.5 * box.dimensions) <= tolerance ? 1U : 0U;
  }
  box.explained =
      static_cast<double>(near) / static_cast<double>(std::max<std::size_t>(1, measured_T.size()));
  if (box.explained < kExplainedMin || !(box.dimensions.minCoeff() > kBoxMin_spacings * spacing)) {
    return ErrorCode::kNoConsensus;
  }
  return box;
}

int snap_ends(const Planes& planes, Cylinder& cylinder) {
  Extent ends{.least = -0.5 * cylinder.length, .most = 0.5 * cylinder.length};
  const double depth_max = kFaceDepthMax * cylinder.length;
  bool low_found = false;
  bool high_found = false;
  // In reverse order: the plane with most points comes last and overrides.
  for (std::size_t i = planes.size(); i-- > 0;) {
    const double height = cylinder.axis_T.dot(planes[i].centre_T - cylinder.centre_T);
    if (std::abs(planes[i].normal_T.dot(cylinder.axis_T)) < kParallelCosineMin) {
      continue;
    }
    if (std::abs(height - 0.5 * cylinder.length) <= depth_max) {
      ends.most = height;
      high_found = true;
    } else if (std::abs(height + 0.5 * cylinder.length) <= depth_max) {
      ends.least = height;
      low_found = true;
    }
  }
  cylinder.centre_T += 0.5 * (ends.least + ends.most) * cylinder.axis_T;
  cylinder.length = ends.most - ends.least;
  return (low_found ? 1 : 0) + (high_found ? 1 : 0);
}

std::size_t complete_box(const Box& box, double pitch, Cloud& cloud) {
  Filler filler = start_filling(pitch, cloud);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Index u = (k + 1) % 3;
    const Eigen::Index v = (k + 2) % 3;
    const int cells_u = cells(box.dimensions(u), pitch);
    const int cells_v = cells(box.dimensions(v), pitch);
    for (const double sign : {-1.0, 1.0}) {
      for (int i = 0; i < cells_u; ++i) {
        for (int j = 0; j < cells_v; ++j) {
          Eigen::Vector3d p_B;
          p_B(k) = 0.5 * sign * box.dimensions(k);
          p_B(u) = ((i + 0.5) / cells_u - 0.5) * box.dimensions(u);
          p_B(v) = ((j + 0.5) / cells_v - 0.5) * box.dimensions(v);
          if (!filler.offer(box.centre_T + box.R_TB * p_B)) {
            return filler.added;
          }
        }
      }
    }
  }
  return filler.added;
}

std::size_t complete_cylinder(const Cylinder& cylinder, double pitch, Cloud& cloud) {
  Filler filler = start_filling(pitch, cloud);
  const Eigen::Vector3d e1 = cylinder.axis_T.unitOrthogonal();
  const Eigen::Vector3d e2 = cylinder.axis_T.cross(e1);
  /// Adds a ring of evenly spaced points; false when the table is full.
  const auto ring = [&](double radius, double height) {
    const int count = cells(2.0 * std::numbers::pi * radius, pitch);
    for (int i = 0; i < count; ++i) {
      const double angle_rad = 2.0 * std::numbers::pi * (i + 0.5) / count;
      if (!filler.offer(cylinder.centre_T + height * cylinder.axis_T +
                        radius * (std::cos(angle_rad) * e1 + std::sin(angle_rad) * e2))) {
        return false;
      }
    }
    return true;
  };
  const int rows = cells(cylinder.length, pitch);
  for (int i = 0; i < rows; ++i) {
    if (!ring(cylinder.radius, ((i + 0.5) / rows - 0.5) * cylinder.length)) {
      return filler.added;
    }
  }
  if (cylinder.ends_found == 0) {
    return filler.added;
  }
  const int rings = cells(cylinder.radius, pitch);
  for (const double sign : {-1.0, 1.0}) {
    for (int i = 0; i < rings; ++i) {
      if (!ring((i + 0.5) / rings * cylinder.radius, 0.5 * sign * cylinder.length)) {
        return filler.added;
      }
    }
  }
  return filler.added;
}

double explained_by(const Cylinder& cylinder, const Cloud& cloud, double tolerance) {
  std::size_t near = 0;
  for (const Eigen::Vector3d& point_T : cloud.points_T.view().first(cloud.measured)) {
    const double height = cylinder.axis_T.dot(point_T - cylinder.centre_T);
    const double outside = cylinder.distance(point_T);
    const bool on_round =
        std::abs(outside) <= tolerance && std::abs(height) <= 0.5 * cylinder.length + tolerance;
    const bool on_end =
        outside <= tolerance && std::abs(std::abs(height) - 0.5 * cylinder.length) <= tolerance;
    near += on_round || on_end ? 1U : 0U;
  }
  return static_cast<double>(near) / static_cast<double>(std::max<std::size_t>(1, cloud.measured));
}

}  // namespace polhode
