// The frame's answer: motion state, observations, packets, jobs.
#pragma once

#include "bus/shape_telemetry.hpp"
#include "pipeline/component.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode {

/// What everything that is published has in common: its unit, and what a contradicted camera adds.
struct PublishedErrors {
  CameraError camera;
  bus::LengthUnit unit;
};
PublishedErrors published_errors(const Component::State& state);

/// Fills `state->answer`. Every accepted frame gets exactly one motion packet, valid or not.
void publish(FrameUse use, std::int64_t timestamp_ns, Component::State* state);

}  // namespace polhode
