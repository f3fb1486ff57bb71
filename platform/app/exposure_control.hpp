// Exposure and gain of the camera, by the levels of the target's pixels: the controller between the
// component and the device.
#pragma once

#include <cstdint>

#include "camera/live_camera.hpp"
#include "image/exposure.hpp"
#include "pipeline/ground_view.hpp"

namespace polhode::platform {

struct ExposureControlOptions {
  bool enabled = true;
  double gain_factor_max =
      16.0;  ///< light at the gain control's highest setting, of that at its lowest
};

/// Input of the controller from one step.
struct SeenTarget {
  LevelCounts levels{};            ///< of its pixels
  double image_motion_px_s = 0.0;  ///< of its fastest points; 0: unknown
};

/// A frame that was refused as dark or saturated counts as all dark, or all saturated.
SeenTarget seen_target(const StepOutput& out, const GroundView& view);

/// The next setting; `now` where nothing is to be changed.
/// @param settings limits of the camera, and its present setting.
CameraExposure next_setting(const SeenTarget& seen,
                            const CameraExposure& settings,
                            double gain_factor_max);

/// After a step. A setting takes effect some frames after it is made, so it is made every few
/// frames.
class ExposureControl {
 public:
  explicit ExposureControl(const ExposureControlOptions& options) : options_(options) {}
  void after(const StepOutput& out, const GroundView& view, LiveCamera& camera);
  [[nodiscard]] std::uint32_t changes() const { return changes_; }

 private:
  static constexpr std::uint32_t kFrames = 4;
  ExposureControlOptions options_;
  std::uint32_t frames_since_ = 0;
  std::uint32_t changes_ = 0;
};

}  // namespace polhode::platform
