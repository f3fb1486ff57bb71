// Read access to a component for tools beside the flight loop: exposure control, records of masks,
// the end of a replay. Flight by packets alone does not use it.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "pipeline/component.hpp"

namespace polhode {

struct CameraFinding;
struct CameraModel;
struct InitialisationState;
struct Map;
struct MapDrift;
struct MaskState;
struct Pose;
struct RigidModel;
struct ScaleState;
struct TargetMask;

/// As the last step left it; valid as long as the component.
struct GroundView {
  const Parameters& parameters;  ///< as they are now: commands change them
  const CameraModel& camera;
  const cv::Mat& gray;  ///< the last imported image
  const TargetMask& mask;
  const MaskState& mask_state;
  const InitialisationState& initialisation;  ///< frames and tracks before there is a map
  const Map& map;
  const MapDrift& drift;
  const Pose& last_pose;                       ///< found last, in map units
  const RigidModel& model;                     ///< of the motion so far
  std::int64_t moves_so_since_ns = INT64_MIN;  ///< time of the last disturbance
  const ScaleState& scale;
  std::uint32_t scale_number = 0;     ///< of the scale, as lengths are published with it
  const CameraFinding& camera_found;  ///< by tests of the stated camera
  std::uint32_t target_frame = 0;     ///< number of the frame T that the map is in
};

/// Has the last adjustment of the whole map fitted the motion together with the map? Only while no
/// job is out: a worker may be writing to it.
bool motion_is_of_map(const Component& component);
bool motion_is_of_map(const Component::State& state);

GroundView view_of(const Component& component);
GroundView view_of(const Component::State& state);

}  // namespace polhode
