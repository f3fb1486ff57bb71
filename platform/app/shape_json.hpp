// shape.json: what the target looks like, in numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "shape/shape.hpp"

namespace polhode::platform {

/// The file is in the frame of the run's other final files: origin in the shape's centroid, axes
/// along the body's. Lengths of the shape are in map units until `metres_per_mu` is known; the file
/// is in metres then.
struct ShapeReport {
  const Shape* shape = nullptr;  ///< null: there is none, and `reason` says why
  std::string reason;
  ScaleSource scale_source = ScaleSource::kNone;
  bool scale_known = false;    ///< lengths of `shape` are metres
  double metres_per_mu = 0.0;  ///< meaningful with scale_known
  double sigma_metres_per_mu = 0.0;
};

void write_shape_json(const std::filesystem::path& file, const ShapeReport& report);

}  // namespace polhode::platform
