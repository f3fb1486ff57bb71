#include "pipeline/published_errors.hpp"

#include <cmath>

#include "pipeline/state.hpp"

namespace polhode {
namespace {

/// Error that a contradicted camera adds in this frame.
CameraError error_by_camera(const Component::State& s) {
  const PoseHistory& recent = s.motion.recent;
  if (!s.mapping.pose_valid && recent.empty()) {
    return error_by(s.camera.found, 0.0);  // lengths are published alone
  }
  const Pose& pose = s.mapping.pose_valid ? s.mapping.localised.absolute.pose : recent.back().pose;
  return error_by(s.camera.found, s.mapping.map.radius_mu / pose.p_CT.norm());
}

}  // namespace

PublishedErrors published_errors(const Component::State& s) {
  const CameraError camera = error_by_camera(s);
  return {
      .camera = camera,
      .unit = {.known = s.scale.known,
               .metres_per_mu = s.scale.metres_per_mu,
               .relative_sigma = std::hypot(length_sigma(s.scale, s.mapping.drift), camera.along),
               .number = number_of(lengths_unit(s), s.bus.scale)}};
}

}  // namespace polhode
