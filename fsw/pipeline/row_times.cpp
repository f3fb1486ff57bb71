#include "pipeline/row_times.hpp"

#include <algorithm>
#include <cmath>

#include "map/localise.hpp"
#include "motion/estimator.hpp"
#include "pipeline/state.hpp"

namespace polhode {

ImageMotion expected_image_motion(std::int64_t timestamp_ns, const Component::State& s) {
  const CameraModel& camera = s.configuration.camera;
  if (camera.line_time_s == 0.0) {
    return {};
  }
  const double readout_ns = 1e9 * std::abs(camera.line_time_s) * camera.height_px;
  const auto half_ns = std::max<std::int64_t>(1, std::llround(0.5 * readout_ns));
  const auto at = [&](std::int64_t time_ns) {
    return predict_or_hold(
        s.motion, s.mapping.drift, s.configuration.parameters.motion, time_ns, s.motion.R_IC);
  };
  const auto before = at(timestamp_ns - half_ns);
  const auto after = at(timestamp_ns + half_ns);
  if (!before || !after) {
    return {};
  }
  const double between_s = 2e-9 * static_cast<double>(half_ns);
  FixedVector<MovingPoint, limits::kFeatures> points;
  for (const Landmark& landmark : s.mapping.map.landmarks) {
    Eigen::Vector2d pixel;
    if (!landmark.used || points.full() ||
        !should_be_seen(landmark, before->pose, camera, &pixel)) {
      continue;
    }
    const Eigen::Vector3d from_C = before->pose.to_camera(landmark.p_T);
    const Eigen::Vector3d to_C = after->pose.to_camera(landmark.p_T);
    if (to_C.z() > 0.0) {
      const Eigen::Vector2d from = from_C.hnormalized();
      const Eigen::Vector2d to = to_C.hnormalized();
      (void)points.push_back(
          {.normalised = 0.5 * (from + to), .velocity_per_s = (to - from) / between_s});
    }
  }
  return fit_image_motion(points.view());
}

}  // namespace polhode
