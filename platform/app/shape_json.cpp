#include "app/shape_json.hpp"

#include <nlohmann/json.hpp>

#include "output_file.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

Json vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The three axes, each in T components.
Json axes(const Eigen::Matrix3d& R_TB) {
  return {{"x_T", vector(R_TB.col(0))}, {"y_T", vector(R_TB.col(1))}, {"z_T", vector(R_TB.col(2))}};
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

Json planes(const Planes& found) {
  Json out = Json::array();
  for (const Plane& plane : found) {
    out.push_back({{"normal_T", vector(plane.normal_T)},
                   {"offset", plane.offset},
                   {"inliers", plane.inliers},
                   {"rms", plane.rms},
                   {"centre_T", vector(plane.centre_T)},
                   {"extents", {plane.extents.x(), plane.extents.y()}},
                   {"extent_axes_T", {vector(plane.axes_T.col(0)), vector(plane.axes_T.col(1))}}});
  }
  return out;
}

Json cylinder(const std::optional<Cylinder>& found) {
  if (!found) {
    return {};
  }
  return {{"axis_T", vector(found->axis_T)},
          {"centre_T", vector(found->centre_T)},
          {"radius", found->radius},
          {"sigma_radius", found->sigma_radius},
          {"length", found->length},
          {"coverage_rad", found->coverage_rad},
          {"inliers", found->inliers},
          {"rms", found->rms}};
}

Json box(const std::optional<Box>& found) {
  if (!found) {
    return {};
  }
  return {{"axes", axes(found->R_TB)},
          {"centre_T", vector(found->centre_T)},
          {"dimensions", vector(found->dimensions)},
          {"sigma_dimensions", vector(found->sigma_dimensions)},
          {"faces_found", found->face_found},
          {"explained", found->explained}};
}

Json content(const Shape& shape) {
  return {
      {"centroid_T", vector(shape.centroid_T)},
      {"centroid_of_measured_T", vector(shape.centroid_measured_T)},
      {"axes", axes(shape.frame.R_TB)},
      {"axes_from", name_of(shape.frame.source)},
      {"dimensions", vector(shape.dimensions)},
      {"sigma_dimensions", vector(shape.sigma_dimensions)},
      {"planes", planes(shape.planes)},
      {"cylinder", cylinder(shape.cylinder)},
      {"box", box(shape.box)},
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
