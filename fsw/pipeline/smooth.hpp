// The end of a replay: the map brought to rest with all that was seen, and every frame's pose from
// it.
//
// This is work for the ground: it takes what memory and time it needs. What flies is step().
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "map/map.hpp"
#include "pipeline/component.hpp"
#include "shape/shape.hpp"
#include "solve/absolute_pose.hpp"

namespace polhode {

struct CameraFit;

/// Joint adjustment of all keyframes and landmarks until nothing moves, with observations looked
/// for anew in every keyframe between the rounds. A job that is still out is ended first: the
/// caller has it no longer. T keeps its axes, origin and scale.
void bring_to_rest(Component* component);

/// Tests the camera by the map at rest, and takes the result in.
CameraFit test_camera_at_rest(Component* component);

struct SmoothedPose {
  bool valid = false;
  AbsolutePose absolute;
  int matches = 0;
};

/// Poses of single frames from the map at rest.
class MapAtRest {
 public:
  explicit MapAtRest(Component* component);

  /// From what the step measured: a keyframe has its adjusted pose, another frame the pose that its
  /// logged observations give. `hint` is the causal pose.
  SmoothedPose from_log(std::uint32_t frame,
                        const Pose& hint,
                        std::span<const Observation> inliers) const;

  /// From the picture itself, for a frame that had no pose at its time: found by descriptors, where
  /// the motion has the target at that time, else over the whole map.
  SmoothedPose from_image(const Frame& frame);

 private:
  Component::State* state_;
  std::vector<std::int32_t> slot_of_number_;  ///< landmark slot by number, -1: gone
};

/// Reads the configured length or range in the keyframe of the configured time.
/// @return false where there is none, or nothing can be read in it.
bool read_scale_in_keyframe(Component* component);

/// Reads it in the picture that MapAtRest::from_image() found a pose for last.
bool read_scale_in_image(Component* component);

/// Reads the configured diameter or edge in a shape, in map units.
bool read_scale_in_shape(const Shape& shape, Component* component);

struct ConfirmedLandmarks {
  std::vector<Eigen::Vector3d> points_T;      ///< in map units
  std::vector<std::int32_t> numbers;          ///< as in the observations
  std::vector<Eigen::Vector3d> directions_T;  ///< unit, mean direction to the cameras that see it
  std::vector<std::int32_t> views;            ///< keyframes that see it
  /// 1-sigma, worst axis, in map units: of its image points, at the scale of all residuals. The
  /// keyframes' poses are taken as exact: the drift of the map is not in it.
  std::vector<double> sigmas;
};

/// Landmarks that three keyframes or more confirm, in slot order.
ConfirmedLandmarks confirmed_landmarks(const Map& map, const CameraModel& camera);

}  // namespace polhode
