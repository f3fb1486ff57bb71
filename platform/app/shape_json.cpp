#include "app/shape_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

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
    case ScaleSource::kDiameter:
      return "known diameter";
    case ScaleSource::kEdge:
      return "known edge";
  }
  return "";
}

const char* name_of(DimensionBasis basis) {
  switch (basis) {
    case DimensionBasis::kNothing:
      return "nothing";
    case DimensionBasis::kPoints:
      return "points";
    case DimensionBasis::kSurfaces:
      return "surfaces";
  }
  return "";
}

/// "none", one name, or several with a plus between them.
std::string sources(const ScaleState& scale) {
  std::string text;
  for (std::size_t i = 0; i < scale.readings.size(); ++i) {
    if (scale.used[i]) {
      text += (text.empty() ? "" : " + ") + std::string(name_of(scale.readings[i].source));
    }
  }
  return text.empty() ? name_of(ScaleSource::kNone) : text;
}

Json scale_json(const ScaleState& scale) {
  Json out{{"known", scale.known}, {"source", sources(scale)}};
  out["metres_per_map_unit"] = scale.known ? Json(scale.metres_per_mu) : Json();
  out["sigma"] = scale.known ? Json(scale.relative_sigma * scale.metres_per_mu) : Json();
  out["contradiction"] = scale.contradiction;
  out["readings"] = Json::array();
  for (std::size_t i = 0; i < scale.readings.size(); ++i) {
    const ScaleReading& reading = scale.readings[i];
    out["readings"].push_back({{"source", name_of(reading.source)},
                               {"metres_per_map_unit", reading.metres_per_mu},
                               {"sigma", reading.sigma},
                               {"used", scale.used[i]}});
  }
  return out;
}

/// Sentences on results that the run could not determine.
Json unknowns(const ShapeReport& report) {
  Json out = Json::array();
  const auto reading_missing = [&report](double given, ScaleSource source) {
    bool read = given == 0.0;
    for (const ScaleReading& reading : report.scale.readings) {
      read = read || reading.source == source;
    }
    return !read;
  };
  const ScaleOptions& given = report.scale_options;
  for (const auto& [value, source] : {std::pair(given.known_length_m, ScaleSource::kKnownLength),
                                      std::pair(given.range_m, ScaleSource::kRange),
                                      std::pair(given.known_diameter_m, ScaleSource::kDiameter),
                                      std::pair(given.known_edge_m, ScaleSource::kEdge)}) {
    if (reading_missing(value, source)) {
      out.push_back(std::string("scale: nothing in the run could be measured against the ") +
                    name_of(source));
    }
  }
  if (report.scale.contradiction) {
    out.push_back("scale: the readings contradict each other");
  }
  if (!report.scale.known) {
    out.push_back("metres: lengths are in map units");
  }
  if (report.shape == nullptr) {
    out.push_back("shape: " + report.reason);
    return out;
  }
  constexpr std::array kAxes{"x", "y", "z"};
  for (std::size_t k = 0; k < kAxes.size(); ++k) {
    const std::string name = kAxes[k];
    const DimensionBasis basis = report.shape->dimension_basis[k];
    if (basis == DimensionBasis::kNothing) {
      out.push_back("dimension " + name + ": the points are flat there");
    } else if (basis == DimensionBasis::kPoints) {
      out.push_back("dimension " + name + ": where the points end, not found by surfaces");
    }
    if (!report.shape->frame.axes_known[k]) {
      out.push_back("axis " + name + ": a choice, the body's geometry does not fix it");
    }
  }
  if (report.surface == nullptr) {
    out.push_back("surface: the points enclose no volume");
  }
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
    out.push_back(
        {{"normal_T", to_T.direction(plane.normal_T)},
         {"offset", plane.offset - plane.normal_T.dot(to_T.centroid_L)},
         {"inliers", plane.inliers},
         {"points_beside", plane.beside},
         {"rms", plane.rms},
         {"sigma_normal_rad", std::sqrt(std::max(plane.covariance(0, 0), plane.covariance(1, 1)))},
         {"sigma_offset", std::sqrt(plane.covariance(2, 2))},
         {"covariance_tilt_u_tilt_v_offset",
          {vector(plane.covariance.row(0)),
           vector(plane.covariance.row(1)),
           vector(plane.covariance.row(2))}},
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
          {"sigma_axis_rad", found->sigma_axis_rad},
          {"centre_T", to_T.point(found->centre_T)},
          {"radius", found->radius},
          {"sigma_radius", found->sigma_radius},
          {"length", found->length},
          {"ends_found", found->ends_found},
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

Json surface(const Hull* hull) {
  if (hull == nullptr) {
    return {};
  }
  return {{"kind", "convex hull"},
          {"vertices", hull->vertices_T.size()},
          {"faces", hull->faces.size()},
          {"volume", hull->volume},
          {"area", hull->area},
          {"points_outside_by", hull->outside}};
}

Json content(const ShapeReport& report) {
  const Shape& shape = *report.shape;
  Json rests_on = Json::array();
  for (const DimensionBasis basis : shape.dimension_basis) {
    rests_on.push_back(name_of(basis));
  }
  const ToTarget to_T(shape);
  return {
      {"centroid_T", to_T.point(shape.centroid_T)},
      {"centroid_of_measured_T", to_T.point(shape.centroid_measured_T)},
      {"axes", axes(to_T.R_TL * shape.frame.R_TB)},
      {"axes_from", name_of(shape.frame.source)},
      {"axes_known", shape.frame.axes_known},
      {"in_the_frame_of_motion_csv",
       {{"centroid", vector(shape.centroid_T)}, {"axes", axes(shape.frame.R_TB)}}},
      {"dimensions", vector(shape.dimensions)},
      {"sigma_dimensions", vector(shape.sigma_dimensions)},
      {"dimensions_rest_on", rests_on},
      {"planes", planes(shape.planes, to_T)},
      {"cylinder", cylinder(shape.cylinder, to_T)},
      {"box", box(shape.box, to_T)},
      {"completion", {{"kind", name_of(shape.completion)}, {"points", shape.completion_points}}},
      {"surface", surface(report.surface)},
      {"landmarks", shape.landmarks},
      {"cloud_points", shape.cloud_points},
      {"spacing", shape.spacing},
      {"thickness", shape.thickness}};
}

}  // namespace

void write_shape_json(const std::filesystem::path& file, const ShapeReport& report) {
  Json out{{"frame", "T"},
           {"unit", report.scale.known ? "m" : "map unit"},
           {"scale", scale_json(report.scale)}};
  out["shape"] = report.shape == nullptr ? Json() : content(report);
  if (report.shape == nullptr) {
    out["reason"] = report.reason;
  }
  out["unknown"] = unknowns(report);
  write_file(file, out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace polhode::platform
