#include "map/validity.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/validity.hpp"

namespace polhode {
namespace {

using validity::is_at_least;
using validity::is_bool;
using validity::is_bounded;
using validity::is_covariance;
using validity::is_past;
using validity::is_rotation;

using AssociationCounts = std::array<std::int32_t, limits::kLandmarks>;

bool is_valid(const Pose& pose) { return is_rotation(pose.R_CT) && is_bounded(pose.p_CT); }

/// Counts the keyframe's observations of each landmark.
bool is_valid(const Keyframe& keyframe,
              const Map& map,
              const CameraModel& camera,
              std::int64_t now_ns,
              AssociationCounts* counts) {
  if (!head_is_valid(keyframe, map, now_ns)) {
    return false;
  }
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId landmark = keyframe.landmark_of[i];
    if (!is_valid(keyframe.features[i], camera) || !association_is_valid(landmark, map)) {
      return false;
    }
    if (landmark.valid()) {
      ++(*counts)[landmark.index()];
    }
  }
  return true;
}

bool is_valid(const LandmarkView& view, const Map& map) {
  const std::int32_t slot = view.keyframe.slot;
  return is_bounded(view.direction_T) && slot >= -1 &&
         slot < static_cast<std::int32_t>(map.keyframes.size()) && view.feature >= -1 &&
         view.feature < static_cast<std::int32_t>(limits::kFeatures);
}

/// No keyframe number twice: ages of landmarks are differences of these numbers.
bool numbers_differ(const Map& map) {
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (map.keyframes[i].used && map.keyframes[j].used &&
          map.keyframes[i].number == map.keyframes[j].number) {
        return false;
      }
    }
  }
  return true;
}

/// Are `count` slots used, and all flags 0 or 1?
template <typename Table>
bool counts_are(const Table& table, std::int32_t count) {
  std::int32_t used = 0;
  for (const auto& slot : table) {
    if (!is_bool(slot.used)) {
      return false;
    }
    used += slot.used ? 1 : 0;
  }
  return used == count;
}

}  // namespace

bool is_valid(const Feature& feature, const CameraModel& camera) {
  // In a model from a nearer pass a keyframe's features may lie outside of the image, by the ratio
  // of the ranges.
  constexpr float kImages = 1024.0F;
  const auto near = [](float pixel, int side_px) {
    return std::abs(pixel) <= kImages * static_cast<float>(side_px);
  };
  return near(feature.u_px, camera.width_px) && near(feature.v_px, camera.height_px) &&
         is_bounded(feature.normalised) && feature.sigma_px > 0.0F &&
         is_bounded(static_cast<double>(feature.sigma_px)) && feature.scale_px > 0.0F &&
         is_bounded(static_cast<double>(feature.scale_px)) &&
         is_bounded(static_cast<double>(feature.angle_rad));
}

bool association_is_valid(LandmarkId landmark, const Map& map) {
  return landmark.slot == -1 || (landmark.slot >= 0 && landmark.index() < map.landmarks.size() &&
                                 map.landmarks[landmark.index()].used);
}

bool head_is_valid(const Keyframe& keyframe, const Map& map, std::int64_t now_ns) {
  return keyframe.number < map.next_keyframe_number && is_past(keyframe.timestamp_ns, now_ns) &&
         is_rotation(keyframe.R_IC) && is_valid(keyframe.pose) && is_before_camera(keyframe.pose) &&
         is_valid(keyframe.refreshed_pose) &&
         keyframe.features.size() <= keyframe.features.capacity();
}

bool head_is_valid(const Landmark& landmark, const Map& map) {
  const bool counted = landmark.number >= 0 && landmark.number < map.next_landmark_number &&
                       landmark.found >= 0 && landmark.predicted >= 0 &&
                       landmark.created_keyframe < map.next_keyframe_number &&
                       landmark.seen_keyframe < map.next_keyframe_number;
  return counted && is_bounded(landmark.p_T) && is_bounded(landmark.normal_T) &&
         is_at_least(landmark.size_mu, 0.0) && is_at_least(landmark.spread_rad, 0.0) &&
         is_bounded(landmark.oldest_direction_T) && is_bool(landmark.observations_changed) &&
         is_bounded(landmark.refreshed_p_T);
}

bool views_are_valid(const Landmark& landmark, const Map& map) {
  return landmark.views.size() <= landmark.views.capacity() &&
         std::all_of(landmark.views.begin(), landmark.views.end(), [&](const LandmarkView& view) {
           return is_valid(view, map);
         });
}

bool is_valid(const Map& map, const CameraModel& camera, std::int64_t now_ns) {
  if (!counts_are(map.keyframes, map.keyframe_count) ||
      !counts_are(map.landmarks, map.landmark_count) || !numbers_differ(map) ||
      map.next_landmark_number < 0 || map.landmark_free_from > map.landmarks.size() ||
      !is_bounded(map.centre_T) || !is_at_least(map.radius_mu, 0.0)) {
    return false;
  }
  AssociationCounts counts{};
  for (const Keyframe& keyframe : map.keyframes) {
    if (keyframe.used && !is_valid(keyframe, map, camera, now_ns, &counts)) {
      return false;
    }
  }
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const Landmark& landmark = map.landmarks[i];
    if (landmark.used && (landmark.observations != counts[i] || !head_is_valid(landmark, map) ||
                          !views_are_valid(landmark, map))) {
      return false;
    }
  }
  return true;
}

bool is_valid(const MapDrift& drift) {
  return is_covariance(drift.walk) && is_covariance(drift.fixed) &&
         is_covariance(drift.reanchoring) && is_rotation(drift.R_first_CT) &&
         is_at_least(drift.initial_turn_sigma, 0.0) && is_at_least(drift.initial_sigma_mu, 0.0) &&
         is_at_least(drift.initial_turn_rad, 0.0) && is_at_least(drift.turn_rad, 0.0);
}

bool is_valid(const FlowReference& reference, const Map& map) {
  const LandmarkMatches& points = reference.points;
  return is_bool(reference.valid) && is_bool(reference.gray_to_come) && is_valid(reference.pose) &&
         points.size() <= points.capacity() &&
         std::all_of(points.begin(), points.end(), [&](const LandmarkMatch& point) {
           return point.landmark.valid() && point.landmark.index() < map.landmarks.size() &&
                  is_bounded(static_cast<double>(point.u_px)) &&
                  is_bounded(static_cast<double>(point.v_px));
         });
}

bool is_valid(const AdjustmentSnapshot& snapshot) {
  const std::size_t poses = snapshot.poses.size();
  const std::size_t points = snapshot.points_T.size();
  const auto in = [](std::int32_t index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  return poses <= snapshot.poses.capacity() && points <= snapshot.points_T.capacity() &&
         snapshot.keyframes.size() == poses && snapshot.keyframe_numbers.size() == poses &&
         snapshot.pose_fixed.size() == poses && snapshot.timestamps_ns.size() == poses &&
         snapshot.R_IC.size() == poses && snapshot.motion.priors.size() <= poses &&
         snapshot.motion.links.size() <= poses && snapshot.landmarks.size() == points &&
         snapshot.landmark_numbers.size() == points && snapshot.point_fixed.size() == points &&
         snapshot.observations.size() <= snapshot.observations.capacity() &&
         std::all_of(snapshot.keyframes.begin(),
                     snapshot.keyframes.end(),
                     [&](KeyframeId id) { return in(id.slot, limits::kKeyframes); }) &&
         std::all_of(snapshot.landmarks.begin(),
                     snapshot.landmarks.end(),
                     [&](LandmarkId id) { return in(id.slot, limits::kLandmarks); }) &&
         std::all_of(snapshot.motion.priors.begin(),
                     snapshot.motion.priors.end(),
                     [&](const PosePrior& prior) { return in(prior.pose, poses); }) &&
         std::all_of(snapshot.motion.links.begin(),
                     snapshot.motion.links.end(),
                     [&](const RateLink& link) {
                       return link.poses.size() <= RateLink::kPoses &&
                              std::all_of(link.poses.begin(),
                                          link.poses.end(),
                                          [&](std::int32_t k) { return in(k, poses); });
                     }) &&
         std::all_of(
             snapshot.observations.begin(),
             snapshot.observations.end(),
             [&](const BundleObservation& o) { return in(o.pose, poses) && in(o.point, points); });
}

}  // namespace polhode
