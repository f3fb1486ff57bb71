// Everything that a component remembers from step to step: the state of each room, in the order of
// the flow. Plain data, owned by whoever owns the memory.
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
  std::uint32_t crc = 0;  ///< CRC-32 over the octets of all entries loaded
  std::uint32_t entries = 0;
};

/// What holds until a command changes it.
struct Configuration {
  Parameters parameters;
  Parameters spare;  ///< as they were when the last step began, should their memory be damaged
  CameraModel camera;
  std::uint32_t table_crc = 0;      ///< of the active table
  bool background_planned = false;  ///< libraries' memory was planned for a mask that tells a
                                    ///< background from the target
  std::size_t memory_octets = 0;    ///< that the component was given
  InactiveTable inactive;
};

/// More than the component was given, or than was planned for the libraries.
bool needs_more_memory(const Parameters& parameters, const Configuration& configuration);

/// Told where each stage ends, so that the caller can time it.
struct StageTimer {
  StageHook hook = nullptr;
  void* context = nullptr;
};

/// What the caller reads after a step.
struct Answer {
  FixedVector<Observation, limits::kPoseMatches> observations;
  StepOutput output;
};

struct Component::State {
  Configuration configuration;
  Counters counters;
  ModeState mode;
  FrameClock clock;
  std::uint32_t steps_to_shed = 0;  ///< for so long less is asked of the libraries
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

/// For what is built on top of a component beside its steps: checkpoints, the end of a replay,
/// tests.
struct ComponentAccess {
  static Component::State* state(Component& component) { return component.state_; }
  static const Component::State* state(const Component& component) { return component.state_; }
};

/// 1-sigma of a metre, and of the map's unit while the initialisation is all it rests on, as a part
/// of it.
inline double length_sigma(const ScaleState& scale, const MapDrift& drift) {
  return std::hypot(scale.relative_sigma, unit_sigma(drift));
}

/// The unit of lengths as they are now.
inline LengthsUnit lengths_unit(const Component::State& state) {
  return {.known = state.scale.known,
          .metres_per_mu = state.scale.metres_per_mu,
          .target_frame = state.mapping.target_frame};
}

/// Tells the caller's hook that a stage has ended.
inline void stage_done(Stage stage, const StageTimer& timer) {
  if (timer.hook != nullptr) {
    timer.hook(timer.context, stage);
  }
}

/// This frame as the map sees it.
MapInput map_input(const Component::State& state);

/// What a reading of the scale needs.
ScaleInput scale_input(const Component::State& state);

/// Of a job that is issued in this step.
JobTimes job_times(const Component::State& state);

/// Nothing is left of the last frame's features, matches, pose and verdict.
void forget_frame(MapState* mapping, PictureState* picture, FeatureState* features);

/// Detects this frame's features, the first time that it is called in a step.
/// @param memory_short  fewer are detected.
void detect_once(const PictureState& picture,
                 const Configuration& configuration,
                 bool memory_short,
                 const StageTimer& timer,
                 FeatureState* features);

}  // namespace polhode
