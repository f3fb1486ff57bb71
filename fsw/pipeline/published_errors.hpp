// Unit and camera error, common to all published values.
#pragma once

#include "bus/length_unit.hpp"
#include "pipeline/component.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode {

/// The unit of lengths, and the error added by a contradicted camera.
struct PublishedErrors {
  CameraError camera;
  bus::LengthUnit unit;
};

PublishedErrors published_errors(const Component::State& state);

}  // namespace polhode
