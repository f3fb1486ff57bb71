// The end of a replay: adjusts the map with all observations until it has converged, and solves
// every frame's pose from it.
//
// This is work for the ground, without bounds of memory and time. Flight uses step() only.
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

/// Joint adjustment of all keyframes and landmarks until convergence. Observations are searched
/// again in every keyframe between the rounds. Jobs that are out are ended first; the caller must
/// not run them any more. T keeps its axes, origin and scale.
void bring_to_rest(Component* component);

/// Tests the camera by the converged map, and takes the result.
CameraFit test_camera_at_rest(Component* component);

struct SmoothedPose {
  bool valid = false;
  AbsolutePose absolute;
  int matches = 0;
};

/// Poses of single frames from the converged map.
class MapAtRest {
 public:
  explicit MapAtRest(Component* component);

  /// From the step's measurements: the adjusted pose of a keyframe, else the pose solved from the
  /// frame's logged observations. `hint` is the causal pose.
  SmoothedPose from_log(std::uint32_t frame,
                        const Pose& hint,
                        std::span<const Observation> inliers) const;

  /// From the image itself, for a frame without a causal pose. Features are matched by descriptors,
  /// about the pose predicted by the motion, else over the whole map.
  SmoothedPose from_image(const Frame& frame);

 private:
  Component::State* state_;
  std::vector<std::int32_t> slot_of_number_;  ///< landmark slot by number, -1: gone
};

/// Reads the configured length or range in the keyframe of the configured time.
/// @return false without such a keyframe, or without a reading in it.
bool read_scale_in_keyframe(Component* component);

/// Reads it in the last image for which MapAtRest::from_image() found a pose.
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
