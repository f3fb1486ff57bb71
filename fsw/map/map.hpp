// The bounded map: keyframes with their features, landmarks, and which feature sees which landmark.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "base/ids.hpp"
#include "config/limits.hpp"
#include "features/detect.hpp"
#include "geometry/pose.hpp"

namespace polhode {

struct Keyframe {
  bool used = false;
  std::uint32_t number = 0;  ///< ascending in time, never used twice
  std::uint32_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude at that time
  Pose pose;
  Features features;
  std::array<LandmarkId, limits::kFeatures> landmark_of{};  ///< per feature
  Pose refreshed_pose;                                      ///< at the last refresh_landmarks()
};

/// Appearance of a landmark from one direction.
struct LandmarkView {
  Eigen::Vector3d direction_T = Eigen::Vector3d::Zero();  ///< unit, towards the camera
  KeyframeId keyframe;  ///< source of the view, and the feature in it
  std::int32_t feature = -1;
  Descriptor descriptor{};
};

struct Landmark {
  static constexpr std::size_t kViews = 3;  ///< cover its range of view in steps that SIFT matches

  // Members that are read of all landmarks in every frame come first, together in memory.
  bool used = false;
  std::int32_t number = -1;       ///< never used twice in a run
  std::int32_t observations = 0;  ///< in keyframes
  std::int32_t found = 0;         ///< frames in which it was matched as an inlier
  std::int32_t predicted = 0;     ///< frames in which it should have been seen
  std::uint32_t created_keyframe = 0;
  std::uint32_t seen_keyframe = 0;  ///< number of the last keyframe that saw it
  Eigen::Vector3d p_T = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_T = Eigen::Vector3d::Zero();  ///< mean direction to the cameras that see
                                                       ///< it, in place of the surface normal
  double size_mu = 0.0;                                ///< radius of its blob on the body
  double spread_rad = 0.0;  ///< largest angle from its oldest direction of view
  Eigen::Vector3d oldest_direction_T = Eigen::Vector3d::Zero();  ///< of view
  FixedVector<LandmarkView, kViews> views;
  bool observations_changed = true;                         ///< since the last refresh_landmarks()
  Eigen::Vector3d refreshed_p_T = Eigen::Vector3d::Zero();  ///< at the last refresh
};

/// Confirmed: seen by three keyframes over 15 deg of rotation. Glints and silhouettes stay in place
/// in the image while the body rotates; over a few degrees they look like points at the depth of
/// the axis, and would slow the estimated rotation down.
inline bool confirmed(const Landmark& landmark) {
  constexpr int kObservationsMin = 3;      // two always fit some depth
  constexpr double kSpreadMin_rad = 0.26;  // 15 deg
  return landmark.observations >= kObservationsMin && landmark.spread_rad >= kSpreadMin_rad;
}

/// With this many confirmed landmarks in view the others are left out: these outline the body and
/// determine a pose (a pose needs 12).
inline constexpr int kConfirmedAlone = 30;

struct Map {
  std::array<Keyframe, limits::kKeyframes> keyframes{};
  std::array<Landmark, limits::kLandmarks> landmarks{};
  std::uint32_t next_keyframe_number = 0;
  std::int32_t next_landmark_number = 0;
  std::int32_t keyframe_count = 0;
  std::int32_t landmark_count = 0;
  std::size_t landmark_free_from = 0;                  ///< no slot before this one is free
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();  ///< median of the landmarks
  double radius_mu = 0.0;                              ///< 90 % of them are nearer to the centre
};

/// @return an invalid id when the table is full.
KeyframeId add_keyframe(Map* map);
LandmarkId add_landmark(Map* map);

/// Frees the slot; the landmark's observations are unassociated.
void remove_landmark(LandmarkId id, Map* map);
/// As remove_landmark() of each, none twice, in one pass over the keyframes.
void remove_landmarks(std::span<const LandmarkId> ids, Map* map);
/// Frees the slot; landmarks that fewer than two keyframes still see go with it.
void remove_keyframe(KeyframeId id, Map* map);

/// Removes the keyframe of that time, if there is one: its image is of another time.
void withdraw_keyframe(std::int64_t timestamp_ns, Map* map);

/// Associates feature `feature` of a keyframe with a landmark; the feature must be free.
void add_observation(KeyframeId keyframe, std::size_t feature, LandmarkId landmark, Map* map);
void remove_observation(KeyframeId keyframe, std::size_t feature, Map* map);

/// Merges two landmarks of one point: the observations of `from` go to `into`, except in keyframes
/// that see `into` already.
void merge_landmarks(LandmarkId from, LandmarkId into, Map* map);

/// Recomputes the mean viewing direction, blob size and views from the keyframes, and the map's
/// extent. Skips landmarks with the same position and observations as at the last time, if their
/// keyframes have not moved.
void refresh_landmarks(Map* map, const CameraModel& camera);

/// The feature that a view shows; null where its keyframe is gone since the views were refreshed.
inline const Feature* feature_of_view(const Map& map, const LandmarkView& view) {
  const Keyframe& keyframe = map.keyframes[view.keyframe.index()];
  const auto place = static_cast<std::size_t>(view.feature);
  const bool there = keyframe.used && place < keyframe.features.size();
  return there ? &keyframe.features[place] : nullptr;
}

/// Slots of the used keyframes, newest first.
FixedVector<KeyframeId, limits::kKeyframes> keyframes_by_age(const Map& map);

void clear(Map* map);

}  // namespace polhode
