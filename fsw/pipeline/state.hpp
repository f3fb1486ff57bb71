// The state that a component keeps from step to step: that of each room, in the order of the flow.
// Plain data, owned by the owner of the memory.
#pragma once

#include <cmath>
#include <cstdint>

#include "bus/bus_state.hpp"
#include "config/limits.hpp"
#include "features/feature_state.hpp"
#include "geometry/camera_model.hpp"
#include "initialisation/collect.hpp"
#include "map/map_state.hpp"
#include "motion/estimator.hpp"
#include "pipeline/component.hpp"
#include "pipeline/frame_clock.hpp"
#include "pipeline/job.hpp"
#include "pipeline/modes.hpp"
#include "pipeline/picture.hpp"
#include "shape/scale_reading.hpp"
#include "shape/scale_state.hpp"
#include "shape/shape_state.hpp"

namespace polhode {

/// A parameter table that is being loaded by command; it becomes active as a whole.
struct InactiveTable {
  bool begun = false;
  Parameters parameters;
  std::uint32_t crc = 0;  ///< CRC-32 over the bytes of all entries loaded
  std::uint32_t entries = 0;
};

/// Settings that hold until a command changes them.
struct Configuration {
  Parameters parameters;
  Parameters spare;  ///< copy from the last step's beginning, for repair
  CameraModel camera;
  std::uint32_t table_crc = 0;      ///< of the active table
  bool background_planned = false;  ///< libraries' memory was planned for a mask that
                                    ///< separates the background from the target
  std::size_t memory_octets = 0;    ///< given to the component
  InactiveTable inactive;
};

/// Do these parameters need more than the component was given, or than was planned for libraries?
bool needs_more_memory(const Parameters& parameters, const Configuration& configuration);

/// Called at the end of each stage, so that the caller can time it.
struct StageTimer {
  StageHook hook = nullptr;
  void* context = nullptr;
};

/// A step's output to the caller.
struct Answer {
  FixedVector<Observation, limits::kPoseMatches> observations;
  StepOutput output;
};

struct Component::State {
  Configuration configuration;
  Counters counters;
  ModeState mode;
  FrameClock clock;
  std::uint32_t steps_to_shed = 0;  ///< steps left with reduced work for libraries
  PictureState picture;
  FeatureState features;
  InitialisationState initialisation;
  MapState mapping;
  MotionEstimate motion;
  ShapeState shape;
  ScaleState scale;
  CameraState camera;
  JobQueue jobs;
  BusState bus;
  Answer answer;
  StageTimer timer;
};

/// Access to the state for code beside the steps: checkpoints, the end of a replay, tests.
struct ComponentAccess {
  static Component::State* state(Component& component) { return component.state_; }
  static const Component::State* state(const Component& component) { return component.state_; }
};

/// Relative 1-sigma of lengths: of the scale, and of the map's unit where it depends on the
/// initialisation alone.
inline double length_sigma(const ScaleState& scale, const MapDrift& drift) {
  return std::hypot(scale.relative_sigma, unit_sigma(drift));
}

/// The present unit of lengths.
inline LengthsUnit lengths_unit(const Component::State& state) {
  return {.known = state.scale.known,
          .metres_per_mu = state.scale.metres_per_mu,
          .target_frame = state.mapping.target_frame};
}

/// Calls the caller's hook at the end of a stage.
inline void stage_done(Stage stage, const StageTimer& timer) {
  if (timer.hook != nullptr) {
    timer.hook(timer.context, stage);
  }
}

/// This frame as the map sees it.
MapInput map_input(const Component::State& state);

/// Input of a reading of the scale.
ScaleInput scale_input(const Component::State& state);

/// Times of a job that is issued in this step.
JobTimes job_times(const Component::State& state);

/// Clears the last frame's features, matches, pose and verdict.
void forget_frame(MapState* mapping, PictureState* picture, FeatureState* features);

/// Detects this frame's features, the first time that it is called in a step.
/// @param memory_short  fewer are detected.
void detect_once(const PictureState& picture,
                 const Configuration& configuration,
                 bool memory_short,
                 const StageTimer& timer,
                 FeatureState* features);

}  // namespace polhode
