// What everything that is published has in common.
#pragma once

#include "bus/length_unit.hpp"
#include "pipeline/component.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode {

/// The unit of lengths, and what a contradicted camera adds to errors.
struct PublishedErrors {
  CameraError camera;
  bus::LengthUnit unit;
};

PublishedErrors published_errors(const Component::State& state);

}  // namespace polhode
