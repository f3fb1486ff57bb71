#include "map/soundness.hpp"

#include <algorithm>
#include <array>

#include "base/sound.hpp"

namespace polhode {
namespace {

using sound::is_at_least;
using sound::is_bool;
using sound::is_bounded;
using sound::is_covariance;
using sound::is_past;
using sound::is_rotation;

using Ties = std::array<std::int32_t, limits::kLandmarks>;

bool is_sound(const Feature& feature, const CameraModel& camera) {
  // Refinement moves a feature by less than a pixel: no farther out of the image.
  constexpr float kBeside_px = 1.0F;
  const bool inside = feature.u_px >= -kBeside_px && feature.v_px >= -kBeside_px &&
                      feature.u_px <= static_cast<float>(camera.width_px) + kBeside_px &&
                      feature.v_px <= static_cast<float>(camera.height_px) + kBeside_px;
  return inside && is_bounded(feature.normalised) && feature.sigma_px > 0.0F &&
         is_bounded(feature.sigma_px) && feature.scale_px > 0.0F && is_bounded(feature.scale_px) &&
         is_bounded(feature.angle_rad);
}

bool is_sound(const Pose& pose) { return is_rotation(pose.R_CT) && is_bounded(pose.p_CT); }

/// Counts the keyframe's ties to each landmark.
bool is_sound(const Keyframe& keyframe,
              const Map& map,
              const CameraModel& camera,
              std::int64_t now_ns,
              Ties* ties) {
  if (keyframe.number >= map.next_keyframe_number || !is_past(keyframe.timestamp_ns, now_ns) ||
      !is_rotation(keyframe.R_IC) || !is_sound(keyframe.pose) ||
      !is_sound(keyframe.refreshed_pose) ||
      keyframe.features.size() > keyframe.features.capacity()) {
    return false;
  }
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const std::int32_t slot = keyframe.landmark_of[i].slot;
    const bool free = slot == -1;
    if (!is_sound(keyframe.features[i], camera) ||
        (!free && (slot < 0 || slot >= static_cast<std::int32_t>(map.landmarks.size()) ||
                   !map.landmarks[static_cast<std::size_t>(slot)].used))) {
      return false;
    }
    if (!free) {
      ++(*ties)[static_cast<std::size_t>(slot)];
    }
  }
  return true;
}

bool is_sound(const LandmarkView& view, const Map& map) {
  const std::int32_t slot = view.keyframe.slot;
  return is_bounded(view.direction_T) && slot >= -1 &&
         slot < static_cast<std::int32_t>(map.keyframes.size()) && view.feature >= -1 &&
         view.feature < static_cast<std::int32_t>(limits::kFeatures);
}

bool is_sound(const Landmark& landmark, const Map& map, std::int32_t ties) {
  const bool counted = landmark.observations == ties && landmark.number >= 0 &&
                       landmark.number < map.next_landmark_number && landmark.found >= 0 &&
                       landmark.predicted >= 0 &&
                       landmark.created_keyframe < map.next_keyframe_number &&
                       landmark.seen_keyframe < map.next_keyframe_number;
  const bool placed = is_bounded(landmark.p_T) && is_bounded(landmark.normal_T) &&
                      is_at_least(landmark.size_mu, 0.0) && is_at_least(landmark.spread_rad, 0.0) &&
                      is_bounded(landmark.oldest_direction_T) &&
                      is_bool(landmark.observations_changed) && is_bounded(landmark.refreshed_p_T);
  return counted && placed && landmark.views.size() <= landmark.views.capacity() &&
         std::all_of(landmark.views.begin(), landmark.views.end(), [&](const LandmarkView& view) {
           return is_sound(view, map);
         });
}

/// No keyframe number twice, as ages are told by them.
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

/// Used slots, as flags that are flags.
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

bool is_sound(const Map& map, const CameraModel& camera, std::int64_t now_ns) {
  if (!counts_are(map.keyframes, map.keyframe_count) ||
      !counts_are(map.landmarks, map.landmark_count) || !numbers_differ(map) ||
      map.next_landmark_number < 0 || map.landmark_free_from > map.landmarks.size() ||
      !is_bounded(map.centre_T) || !is_at_least(map.radius_mu, 0.0)) {
    return false;
  }
  Ties ties{};
  for (const Keyframe& keyframe : map.keyframes) {
    if (keyframe.used && !is_sound(keyframe, map, camera, now_ns, &ties)) {
      return false;
    }
  }
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (map.landmarks[i].used && !is_sound(map.landmarks[i], map, ties[i])) {
      return false;
    }
  }
  return true;
}

bool is_sound(const MapDrift& drift) {
  return is_covariance(drift.walk) && is_covariance(drift.held) &&
         is_covariance(drift.reanchoring) && is_rotation(drift.R_first_CT) &&
         is_at_least(drift.start_turn_sigma, 0.0) && is_at_least(drift.start_sigma_mu, 0.0) &&
         is_at_least(drift.start_turn_rad, 0.0) && is_at_least(drift.turn_rad, 0.0);
}

}  // namespace polhode
