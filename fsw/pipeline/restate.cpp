#include "pipeline/restate.hpp"

#include <algorithm>

#include "map/keyframes.hpp"
#include "pipeline/localise_input.hpp"
#include "pipeline/motion_jobs.hpp"

namespace polhode {
namespace {

/// This frame's own matches and pose, from the keyframe that it has become.
bool pose_from_keyframe(const Keyframe& keyframe, Component::State* s) {
  s->localised.matches.clear();
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    if (id.valid()) {
      const Feature& f = keyframe.features[i];
      (void)s->localised.matches.push_back({.landmark = id,
                                            .feature = static_cast<std::int32_t>(i),
                                            .u_px = f.u_px,
                                            .v_px = f.v_px,
                                            .normalised = f.normalised,
                                            .sigma_px = static_cast<double>(f.sigma_px)});
    }
  }
  s->localised.predicted = static_cast<int>(s->localised.matches.size());
  return solve_matched(localise_input(*s), &keyframe.pose, &s->localise_scratch, &s->localised)
      .ok();
}

bool belongs_to_start(const Keyframe& keyframe, const Component::State& s) {
  return keyframe.used && keyframe.number >= s.job.adjustment.first_keyframe;
}

}  // namespace

void restate_poses(Component::State* s) {
  StartPoses poses;
  auto order = keyframes_by_age(s->map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    const Keyframe& keyframe = s->map.keyframes[id.index()];
    if (!belongs_to_start(keyframe, *s)) {
      continue;
    }
    const bool solved = pose_from_keyframe(keyframe, s);
    if (keyframe.frame != s->frame && solved) {
      (void)poses.push_back(turned(keyframe.R_IC,
                                   PoseSample{.timestamp_ns = keyframe.timestamp_ns,
                                              .pose = s->localised.absolute.pose,
                                              .covariance = s->localised.absolute.covariance}));
    }
    s->pose_valid = keyframe.frame == s->frame && solved;
  }
  restate_motion(poses.view(), s);
}

}  // namespace polhode
