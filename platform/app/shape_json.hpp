// shape.json: the target's shape, in numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "shape/hull.hpp"
#include "shape/scale_state.hpp"
#include "shape/shape.hpp"

namespace polhode::platform {

/// The file is in the frame of the run's other final files: origin in the shape's centroid, axes
/// along the body's. Lengths of the shape are in map units until the scale is known; they, and the
/// file, are in metres then.
struct ShapeReport {
  const Shape* shape = nullptr;  ///< null: there is none, for `reason`
  std::string reason;
  const Hull* surface = nullptr;  ///< null: the points enclose nothing
  ScaleOptions scale_options{};   ///< as configured
  ScaleState scale{};
};

void write_shape_json(const std::filesystem::path& file, const ShapeReport& report);

}  // namespace polhode::platform
