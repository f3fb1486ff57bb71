#include "map/closure.hpp"

#include <algorithm>

#include "geometry/so3.hpp"
#include "map/map_state.hpp"

namespace polhode {
namespace {

bool accepted(const LocalisedFrame& found, const Pose& pose, const ClosureOptions& options) {
  const int inliers = found.absolute.inliers;
  return inliers >= options.inliers_min &&
         inliers >= options.inlier_fraction_min * static_cast<double>(found.matches.size()) &&
         rotation_angle_rad(found.absolute.pose.R_CT, pose.R_CT) < options.turn_max_rad;
}

bool sees(const Keyframe& keyframe, LandmarkId landmark) {
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i] == landmark) {
      return true;
    }
  }
  return false;
}

}  // namespace

int close_loop(LocaliseInput input,
               KeyframeId id,
               const ClosureOptions& options,
               MapScratch* scratch,
               Map* map) {
  LocalisedFrame* work = &scratch->other;
  input.age = LandmarkAge::kOld;
  const Keyframe& keyframe = map->keyframes[id.index()];
  // The drift that turn_max_rad allows, seen at the body's edge.
  constexpr double kReach_radii = 0.33;
  const double radius_px =
      kReach_radii * map->radius_mu * input.camera->focal_px() / keyframe.pose.p_CT.z();
  match_about(input, keyframe.pose, radius_px, &scratch->localise, work);
  if (!solve_matched(input, nullptr, &scratch->localise, work) ||
      !accepted(*work, keyframe.pose, options)) {
    return 0;
  }
  int associated = 0;
  for (const LandmarkMatch& match : work->matches) {
    const auto feature = static_cast<std::size_t>(match.feature);
    const LandmarkId young = keyframe.landmark_of[feature];
    if (!match.inlier || young == match.landmark) {
      continue;
    }
    if (young.valid()) {
      merge_landmarks(young, match.landmark, map);
      ++associated;
    }
    if (!keyframe.landmark_of[feature].valid() && !sees(keyframe, match.landmark)) {
      add_observation(id, feature, match.landmark, map);
      ++associated;
    }
  }
  return associated;
}

}  // namespace polhode
