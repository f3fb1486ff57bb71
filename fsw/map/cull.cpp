// Culling: drops observations by their residuals, and landmarks by their observations.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "base/median.hpp"
#include "map/landmarks.hpp"
#include "solve/absolute_pose.hpp"

namespace polhode {
namespace {

double squared_residual(const Keyframe& keyframe,
                        std::size_t feature,
                        const Landmark& landmark,
                        double focal_px) {
  const Eigen::Vector3d p_C = keyframe.pose.to_camera(landmark.p_T);
  if (!(p_C.z() > 0.0)) {
    return std::numeric_limits<double>::max();
  }
  const Feature& f = keyframe.features[feature];
  const double sigma = static_cast<double>(f.sigma_px) / focal_px;
  return (p_C.hnormalized() - f.normalised).squaredNorm() / (sigma * sigma);
}

bool is_bad(const Landmark& landmark, std::uint32_t keyframe_newest) {
  // Frames and keyframes after which a landmark is decided on. Chosen; with fewer frames a good one
  // that was missed by chance goes, with more keyframes false ones stay.
  constexpr int kTrialFrames = 4;
  constexpr std::uint32_t kTrialKeyframes = 3;
  const bool unseen = landmark.observations < 2;
  const bool unconfirmed =
      landmark.observations < 3 && keyframe_newest > landmark.created_keyframe + kTrialKeyframes;
  const bool rarely_found = landmark.predicted >= kTrialFrames &&
                            4 * landmark.found < landmark.predicted && landmark.observations < 4;
  return unseen || unconfirmed || rarely_found;
}

}  // namespace

double residual_scale(const Map& map, const CameraModel& camera) {
  FixedVector<double, 16384> squares;
  const double focal_px = camera.focal_px();
  for (const Keyframe& keyframe : map.keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      if (id.valid() && map.landmarks[id.index()].observations > 2 && !squares.full()) {
        (void)squares.push_back(squared_residual(keyframe, i, map.landmarks[id.index()], focal_px));
      }
    }
  }
  if (squares.size() < 20) {
    return 1.0;
  }
  constexpr double kMedianChi2 = 1.386;  // of two coordinates
  return std::sqrt(median(squares.view()) / kMedianChi2);
}

int cull_landmarks(const CameraModel& camera, double noise_scale, Map* map) {
  const double limit = kInlierChi2 * noise_scale * noise_scale;
  const double focal_px = camera.focal_px();
  for (std::size_t k = 0; k < map->keyframes.size(); ++k) {
    Keyframe& keyframe = map->keyframes[k];
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      if (id.valid() &&
          squared_residual(keyframe, i, map->landmarks[id.index()], focal_px) > limit) {
        remove_observation(KeyframeId::from_index(k), i, map);
      }
    }
  }
  const std::uint32_t newest = map->next_keyframe_number;
  FixedVector<LandmarkId, limits::kLandmarks> bad;
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    if (map->landmarks[i].used && is_bad(map->landmarks[i], newest)) {
      (void)bad.push_back(LandmarkId::from_index(i));
    }
  }
  remove_landmarks(bad.view(), map);
  return static_cast<int>(bad.size());
}

}  // namespace polhode
