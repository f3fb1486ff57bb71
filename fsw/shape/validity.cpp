#include "shape/validity.hpp"

#include <algorithm>

#include "base/validity.hpp"

namespace polhode {
namespace {

using validity::is_at_least;
using validity::is_bool;
using validity::is_bounded;
using validity::is_covariance;
using validity::is_enum;
using validity::is_rotation;
using validity::is_unit;

template <typename Flags>
bool are_bools(const Flags& flags) {
  return std::all_of(flags.begin(), flags.end(), is_bool);
}

bool is_valid(const Plane& plane) {
  return is_unit(plane.normal_T) && is_bounded(plane.offset) && is_bounded(plane.centre_T) &&
         is_bounded(plane.axes_T) && is_bounded(plane.extents) && is_at_least(plane.rms, 0.0) &&
         is_covariance(plane.covariance) && plane.inliers <= limits::kCloudPoints &&
         plane.beside <= limits::kCloudPoints;
}

bool is_valid(const Cylinder& cylinder) {
  constexpr int kEnds = 2;  // a cylinder has no more
  return is_unit(cylinder.axis_T) && is_bounded(cylinder.centre_T) &&
         is_at_least(cylinder.radius, 0.0) && is_at_least(cylinder.length, 0.0) &&
         is_at_least(cylinder.coverage_rad, 0.0) && cylinder.ends_found >= 0 &&
         cylinder.ends_found <= kEnds && cylinder.inliers <= limits::kCloudPoints &&
         cylinder.beside <= limits::kCloudPoints && is_at_least(cylinder.rms, 0.0) &&
         is_at_least(cylinder.sigma_axis_rad, 0.0) && is_at_least(cylinder.sigma_radius, 0.0);
}

bool is_valid(const Box& box) {
  return is_rotation(box.R_TB) && is_bounded(box.centre_T) && is_bounded(box.dimensions) &&
         is_bounded(box.sigma_dimensions) && are_bools(box.face_found) && is_bounded(box.explained);
}

bool is_valid(const TargetFrame& frame) {
  return is_rotation(frame.R_TB) && is_enum(frame.source, FrameSource::kCylinder) &&
         are_bools(frame.axes_known);
}

bool is_valid(const Shape& shape) {
  const bool numbers = is_at_least(shape.spacing, 0.0) && is_at_least(shape.thickness, 0.0) &&
                       shape.landmarks <= limits::kLandmarks &&
                       shape.cloud_points <= limits::kCloudPoints &&
                       shape.completion_points <= limits::kCloudPoints &&
                       is_bounded(shape.centroid_measured_T) && is_bounded(shape.centroid_T) &&
                       is_bounded(shape.dimensions) && is_bounded(shape.sigma_dimensions);
  const bool kinds =
      is_enum(shape.completion, CompletionKind::kCylinder) &&
      std::all_of(shape.dimension_basis.begin(),
                  shape.dimension_basis.end(),
                  [](DimensionBasis basis) { return is_enum(basis, DimensionBasis::kSurfaces); });
  return numbers && kinds && is_valid(shape.frame) &&
         shape.planes.size() <= shape.planes.capacity() &&
         std::all_of(shape.planes.begin(),
                     shape.planes.end(),
                     [](const Plane& plane) { return is_valid(plane); }) &&
         (!shape.cylinder || is_valid(*shape.cylinder)) && (!shape.box || is_valid(*shape.box));
}

bool is_valid(const ScaleReading& reading) {
  return is_enum(reading.source, ScaleSource::kEdge) && is_at_least(reading.metres_per_mu, 0.0) &&
         is_at_least(reading.sigma, 0.0);
}

}  // namespace

bool is_valid(const ShapeState& shape) {
  return is_bool(shape.asked) && is_bool(shape.is_new) && (!shape.shape || is_valid(*shape.shape));
}

bool is_valid(const ScaleState& scale) {
  constexpr double kMetresMin = 1e-12;  // its reciprocal has the same bound as the scale
  return is_bool(scale.known) && is_at_least(scale.metres_per_mu, kMetresMin) &&
         is_at_least(scale.relative_sigma, 0.0) &&
         scale.readings.size() <= scale.readings.capacity() &&
         std::all_of(scale.readings.begin(),
                     scale.readings.end(),
                     [](const ScaleReading& reading) { return is_valid(reading); }) &&
         are_bools(scale.used) && is_bool(scale.contradiction);
}

}  // namespace polhode
