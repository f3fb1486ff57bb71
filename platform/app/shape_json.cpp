#include "app/shape_json.hpp"

#include <nlohmann/json.hpp>

#include "output_file.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

Json vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The columns of a rotation: a body's axes.
Json axes(const Eigen::Matrix3d& R) {
  return {{"x", vector(R.col(0))}, {"y", vector(R.col(1))}, {"z", vector(R.col(2))}};
}

const char* name_of(FrameSource source) {
  switch (source) {
    case FrameSource::kPrincipal:
      return "principal axes of the cloud";
    case FrameSource::kPlanes:
      return "planes";
    case FrameSource::kCylinder:
      return "cylinder";
  }
  return "";
}

const char* name_of(CompletionKind kind) {
  switch (kind) {
    case CompletionKind::kNone:
      return "none";
    case CompletionKind::kBox:
      return "box";
    case CompletionKind::kCylinder:
      return "cylinder";
  }
  return "";
}

const char* name_of(ScaleSource source) {
  switch (source) {
    case ScaleSource::kNone:
      return "none";
    case ScaleSource::kKnownLength:
      return "known length";
    case ScaleSource::kRange:
      return "range";
  }
  return "";
}

Json scale(const ShapeReport& report) {
  Json out{{"known", report.scale_known}, {"source", name_of(report.scale_source)}};
  out["metres_per_map_unit"] = report.scale_known ? Json(report.metres_per_mu) : Json();
  out["sigma"] = report.scale_known ? Json(report.sigma_metres_per_mu) : Json();
  return out;
}

/// From the frame of the landmarks (L) to the target frame of the files: origin in the centroid,
/// axes along the body's.
struct ToTarget {
  explicit ToTarget(const Shape& shape)
      : R_TL(shape.frame.R_TB.transpose()), centroid_L(shape.centroid_T) {}
  [[nodiscard]] Json direction(const Eigen::Vector3d& d_L) const { return vector(R_TL * d_L); }
  [[nodiscard]] Json point(const Eigen::Vector3d& p_L) const {
    return vector(R_TL * (p_L - centroid_L));
  }

  Eigen::Matrix3d R_TL;
  Eigen::Vector3d centroid_L;
};

Json planes(const Planes& found, const ToTarget& to_T) {
  Json out = Json::array();
  for (const Plane& plane : found) {
    out.push_back({{"normal_T", to_T.direction(plane.normal_T)},
                   {"offset", plane.offset - plane.normal_T.dot(to_T.centroid_L)},
                   {"inliers", plane.inliers},
                   {"rms", plane.rms},
                   {"centre_T", to_T.point(plane.centre_T)},
                   {"extents", {plane.extents.x(), plane.extents.y()}},
                   {"extent_axes_T",
                    {to_T.direction(plane.axes_T.col(0)), to_T.direction(plane.axes_T.col(1))}}});
  }
  return out;
}

Json cylinder(const std::optional<Cylinder>& found, const ToTarget& to_T) {
  if (!found) {
    return {};
  }
  return {{"axis_T", to_T.direction(found->axis_T)},
          {"centre_T", to_T.point(found->centre_T)},
          {"radius", found->radius},
          {"sigma_radius", found->sigma_radius},
          {"length", found->length},
          {"coverage_rad", found->coverage_rad},
          {"inliers", found->inliers},
          {"rms", found->rms}};
}

Json box(const std::optional<Box>& found, const ToTarget& to_T) {
  if (!found) {
    return {};
  }
  return {{"axes", axes(to_T.R_TL * found->R_TB)},
          {"centre_T", to_T.point(found->centre_T)},
          {"dimensions", vector(found->dimensions)},
          {"sigma_dimensions", vector(found->sigma_dimensions)},
          {"faces_found", found->face_found},
          {"explained", found->explained}};
}

Json content(const Shape& shape) {
  const ToTarget to_T(shape);
  return {
      {"centroid_T", to_T.point(shape.centroid_T)},
      {"centroid_of_measured_T", to_T.point(shape.centroid_measured_T)},
      {"axes", axes(to_T.R_TL * shape.frame.R_TB)},
      {"axes_from", name_of(shape.frame.source)},
      {"in_the_frame_of_motion_csv",
       {{"centroid", vector(shape.centroid_T)}, {"axes", axes(shape.frame.R_TB)}}},
      {"dimensions", vector(shape.dimensions)},
      {"sigma_dimensions", vector(shape.sigma_dimensions)},
      {"planes", planes(shape.planes, to_T)},
      {"cylinder", cylinder(shape.cylinder, to_T)},
      {"box", box(shape.box, to_T)},
      {"completion", {{"kind", name_of(shape.completion)}, {"points", shape.completion_points}}},
      {"landmarks", shape.landmarks},
      {"cloud_points", shape.cloud_points},
      {"spacing", shape.spacing},
      {"thickness", shape.thickness}};
}

}  // namespace

void write_shape_json(const std::filesystem::path& file, const ShapeReport& report) {
  Json out{
      {"frame", "T"}, {"unit", report.scale_known ? "m" : "map unit"}, {"scale", scale(report)}};
  out["shape"] = report.shape == nullptr ? Json() : content(*report.shape);
  if (report.shape == nullptr) {
    out["reason"] = report.reason;
  }
  write_file(file, out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace polhode::platform
