// Exposure and gain for the next frame, from the levels of the target's pixels in this one.
#pragma once

#include <array>
#include <cstdint>

namespace polhode {

/// Pixels by level.
using LevelCounts = std::array<std::uint32_t, 256>;

struct Exposure {
  double exposure_s = 0.01;
  double gain = 1.0;
};

/// Limits and response of the camera. Its driver fills this in; the defaults are for tests.
struct ExposureRange {
  double exposure_min_s = 1e-5;
  double exposure_max_s = 0.1;
  double gain_min = 1.0;
  double gain_max = 16.0;
  double response_gamma = 1.0;  ///< level = light^(1 / gamma); 1 is linear
};

struct ExposureOptions {
  // Chosen: leaves room for glints. Larger saturates more of the body, smaller darkens it for a
  // glint.
  double bright_part = 0.02;  ///< this part of the target's pixels may exceed `bright_level`
  // Chosen: room for a quarter more light in the next frame.
  double bright_level = 0.8;  ///< of full scale
  // Chosen: under 2.5, the factor by which the verdict takes a frame for dark.
  double step_max = 2.0;  ///< factor of light from a frame to the next at most
  // Chosen; larger stays farther from `bright_level`, smaller follows the noise of the levels.
  double dead_band = 0.1;  ///< smaller relative changes cause no step
  // Chosen: less than a pixel. Larger blurs the finest blobs, smaller takes more gain and noise.
  double blur_max_px = 0.5;  ///< image motion during an exposure
};

/// Brings the brightest pixels of the target, not the background's, under saturation. Their level
/// goes to `bright_level` in steps of at most `step_max`. The exposure is the longest that blurs no
/// more than `blur_max_px` at the predicted image motion; gain makes up for the rest.
/// @param target levels of the target's pixels; none: the settings stay.
/// @param image_motion_px_s of the target's fastest points; 0: unknown or none.
/// @return within `range`. Pure.
Exposure next_exposure(const LevelCounts& target,
                       const Exposure& now,
                       double image_motion_px_s,
                       const ExposureRange& range,
                       const ExposureOptions& options);

}  // namespace polhode
