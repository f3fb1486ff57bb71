#include "pipeline/scale_now.hpp"

#include "shape/scale.hpp"

namespace polhode {
namespace {

using SeenLandmarks = FixedVector<Eigen::Vector3d, limits::kFeatures>;

SeenLandmarks seen_in_this_frame(const Component::State& s) {
  SeenLandmarks seen;
  for (const LandmarkMatch& match : s.localised.matches) {
    const Landmark& landmark = s.map.landmarks[match.landmark.index()];
    if (match.inlier && landmark.used) {
      (void)seen.push_back(landmark.p_T);
    }
  }
  return seen;
}

SeenLandmarks seen_in(const Keyframe& keyframe, const Map& map) {
  SeenLandmarks seen;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i].valid()) {
      (void)seen.push_back(map.landmarks[keyframe.landmark_of[i].index()].p_T);
    }
  }
  return seen;
}

}  // namespace

bool measure_scale_in(const Pose& pose,
                      std::span<const Eigen::Vector3d> landmarks_T,
                      Component::State* s) {
  const ScaleOptions& options = s->parameters.scale;
  const ScaleView view{.pose = pose, .landmarks_T = landmarks_T};
  const auto ray = [&](std::size_t end) {
    return undistort(s->camera, {options.points_px[end][0], options.points_px[end][1]});
  };
  // A point picked in a picture by a person or an edge finder is good to a pixel.
  const double sigma_ray = 1.0 / s->camera.focal_px();
  const Result<ScaleEstimate> scale =
      options.source == ScaleSource::kKnownLength
          ? scale_from_length(view, ray(0), ray(1), options.known_length_m, sigma_ray)
          : scale_from_range(view, options.range_m, 0.0);
  if (!scale) {
    return false;
  }
  s->scale = {.known = true,
              .metres_per_mu = scale.value().metres_per_mu,
              .relative_sigma = scale.value().sigma / scale.value().metres_per_mu};
  return true;
}

void measure_scale(Component::State* s) {
  if (s->parameters.scale.source == ScaleSource::kNone || s->scale.known || !s->pose_valid) {
    return;
  }
  const std::int64_t wanted_ns = s->parameters.scale.frame_timestamp_ns;
  if (s->timestamp_ns == wanted_ns) {
    (void)measure_scale_in(s->localised.absolute.pose, seen_in_this_frame(*s).view(), s);
    return;
  }
  for (const Keyframe& keyframe : s->map.keyframes) {
    if (keyframe.used && keyframe.timestamp_ns == wanted_ns) {
      (void)measure_scale_in(keyframe.pose, seen_in(keyframe, s->map).view(), s);
      return;
    }
  }
}

}  // namespace polhode
