#include "app/exposure_control.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/camera_model.hpp"
#include "map/map.hpp"
#include "mask/mask_state.hpp"
#include "mask/target_levels.hpp"

namespace polhode::platform {
namespace {

/// Of the points of the body's edge: it turns, and moves across.
double image_motion_px_s(const MotionState& motion, const GroundView& view) {
  const double depth = motion.p_CT[2];
  if (!motion.pose_valid || !motion.rate_valid || depth <= 0.0) {
    return 0.0;
  }
  const double radius_px = view.camera.focal_px() * view.map.radius_mu / view.last_pose.p_CT.z();
  const double across = motion.velocity_valid ? std::hypot(motion.v_C[0], motion.v_C[1]) : 0.0;
  return Eigen::Map<const Eigen::Vector3d>(motion.w_T_rad_s.data()).norm() * std::abs(radius_px) +
         view.camera.focal_px() * across / depth;
}

/// Before black space, where all that there is passes for empty space, it is too dark: a body that
/// the component does not call dark may still be under the mask's level.
LevelCounts used_levels(const GroundView& view) {
  LevelCounts levels = target_levels(view.gray, view.parameters.mask, view.mask);
  const bool none =
      std::all_of(levels.begin(), levels.end(), [](std::uint32_t n) { return n == 0; });
  if (none && !view.mask_state.behind) {
    levels.front() = 1;
  }
  return levels;
}

/// One level all over: where it is more than a target should have it is too much light, where a
/// target would pass for empty space too little, else nothing is known.
LevelCounts flat_levels(const cv::Mat& gray, const MaskOptions& mask) {
  LevelCounts levels{};
  const double mean = cv::mean(gray)[0];
  if (mean > 255.0 * ExposureOptions{}.bright_level || mean <= 255.0 * mask.dark_level) {
    levels[static_cast<std::size_t>(mean)] = 1;
  }
  return levels;
}

}  // namespace

SeenTarget seen_target(const StepOutput& out, const GroundView& view) {
  SeenTarget seen;
  switch (out.use) {
    case FrameUse::kDark:
      seen.levels.front() = 1;
      break;
    case FrameUse::kSaturated:
      seen.levels.back() = 1;
      break;
    case FrameUse::kUsed:
      seen.levels = used_levels(view);
      seen.image_motion_px_s = image_motion_px_s(out.motion, view);
      break;
    case FrameUse::kFlat:
      seen.levels = flat_levels(view.gray, view.parameters.mask);
      break;
    default:  // a damaged image has no usable levels
      break;
  }
  return seen;
}

CameraExposure next_setting(const SeenTarget& seen,
                            const CameraExposure& now,
                            double gain_factor_max) {
  constexpr double kSecond_ns = 1e9;
  const double gain_span = now.has_gain ? gain_factor_max - 1.0 : 0.0;
  const ExposureRange range{.exposure_min_s = static_cast<double>(now.exposure_min_ns) / kSecond_ns,
                            .exposure_max_s = static_cast<double>(now.exposure_max_ns) / kSecond_ns,
                            .gain_min = 1.0,
                            .gain_max = 1.0 + gain_span};
  const Exposure before{.exposure_s = static_cast<double>(now.exposure_ns) / kSecond_ns,
                        .gain = 1.0 + gain_span * now.gain};
  const Exposure next = next_exposure(seen.levels, before, seen.image_motion_px_s, range, {});
  CameraExposure setting = now;
  setting.exposure_ns = std::llround(next.exposure_s * kSecond_ns);
  setting.gain = gain_span > 0.0 ? std::clamp((next.gain - 1.0) / gain_span, 0.0, 1.0) : now.gain;
  return setting;
}

void ExposureControl::after(const StepOutput& out, const GroundView& view, LiveCamera& camera) {
  if (!options_.enabled || ++frames_since_ < kFrames) {
    return;
  }
  const CameraExposure now = camera.exposure();
  if (!now.settable) {
    return;
  }
  frames_since_ = 0;
  const CameraExposure next = next_setting(seen_target(out, view), now, options_.gain_factor_max);
  // Steps of the device are coarse: a setting that is nearly the same is kept.
  constexpr double kSame = 0.02;
  const bool same = std::abs(static_cast<double>(next.exposure_ns - now.exposure_ns)) <
                        kSame * static_cast<double>(now.exposure_ns) &&
                    std::abs(next.gain - now.gain) * options_.gain_factor_max <
                        kSame * (1.0 + (options_.gain_factor_max - 1.0) * now.gain);
  if (!same) {
    camera.set_exposure(next.exposure_ns, now.has_gain ? next.gain : -1.0);
    ++changes_;
  }
}

}  // namespace polhode::platform
