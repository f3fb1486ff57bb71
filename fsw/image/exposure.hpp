// Exposure and gain for the next frame, from what the target's pixels were in this one.
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

/// What the camera can do.
struct ExposureRange {
  double exposure_min_s = 1e-5;
  double exposure_max_s = 0.1;
  double gain_min = 1.0;
  double gain_max = 16.0;
  double response_gamma = 1.0;  ///< level = light^(1 / gamma); 1 is linear
};

struct ExposureOptions {
  double bright_part = 0.02;  ///< this part of the target's pixels may exceed `bright_level`
  double bright_level = 0.8;  ///< of full scale
  double step_max = 2.0;      ///< factor of light from a frame to the next at most
  double dead_band = 0.1;     ///< relative change that is not worth a step
  double blur_max_px = 0.5;   ///< image motion during an exposure
};

/// Brings the brightest pixels of the target (not the background's) under saturation: their level
/// goes to `bright_level` in steps of at most `step_max`. Of exposure and gain that give that light
/// the one with the longest exposure that blurs no more than `blur_max_px` at the image motion
/// predicted; gain makes up for the rest.
/// @param target levels of the target's pixels; none: the settings stay.
/// @param image_motion_px_s of the target's fastest points; 0: unknown or none.
/// @return within `range`. Pure.
Exposure next_exposure(const LevelCounts& target,
                       const Exposure& now,
                       double image_motion_px_s,
                       const ExposureRange& range,
                       const ExposureOptions& options);

}  // namespace polhode
