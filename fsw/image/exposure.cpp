#include "image/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace polhode {
namespace {

/// Level that `part` of the pixels exceed, 0 .. 1.
double level_exceeded(const LevelCounts& counts, double total, double part) {
  double above = 0.0;
  for (std::size_t level = counts.size(); level-- > 0;) {
    above += counts[level];
    if (above > part * total) {
      return static_cast<double>(level) / 255.0;
    }
  }
  return 0.0;
}

/// Factor of light that brings the bright pixels to their level. Saturated pixels do not measure
/// the excess of light: the more of them, the larger the step.
double wanted_factor(const LevelCounts& counts,
                     double total,
                     double gamma,
                     const ExposureOptions& options) {
  constexpr std::size_t kSaturated = 250;    // 0.98 of full scale, as ImageOptions has it
  constexpr double kLevelMin = 1.0 / 255.0;  // the least over zero
  const double saturated = std::accumulate(counts.begin() + kSaturated, counts.end(), 0.0) / total;
  const double bright = std::max(kLevelMin, level_exceeded(counts, total, options.bright_part));
  double factor = std::pow(options.bright_level / bright, gamma);
  if (saturated > options.bright_part) {
    // Part of saturated pixels with the largest step. Chosen: ten times the part that may be
    // bright.
    constexpr double kMany = 0.2;
    const double weight = std::min(1.0, saturated / kMany);
    factor = std::min(factor, std::pow(options.step_max, -weight));
  }
  return std::clamp(factor, 1.0 / options.step_max, options.step_max);
}

}  // namespace

Exposure next_exposure(const LevelCounts& target,
                       const Exposure& now,
                       double image_motion_px_s,
                       const ExposureRange& range,
                       const ExposureOptions& options) {
  const double total = std::accumulate(target.begin(), target.end(), 0.0);
  if (!(total > 0.0)) {
    return {.exposure_s = std::clamp(now.exposure_s, range.exposure_min_s, range.exposure_max_s),
            .gain = std::clamp(now.gain, range.gain_min, range.gain_max)};
  }
  double factor = wanted_factor(target, total, range.response_gamma, options);
  if (std::abs(factor - 1.0) < options.dead_band) {
    factor = 1.0;
  }
  const double light = now.exposure_s * now.gain * factor;
  double longest_s = range.exposure_max_s;
  if (image_motion_px_s > 0.0) {
    longest_s = std::min(longest_s, options.blur_max_px / image_motion_px_s);
  }
  longest_s = std::max(longest_s, range.exposure_min_s);
  Exposure next;
  next.exposure_s = std::clamp(light / range.gain_min, range.exposure_min_s, longest_s);
  next.gain = std::clamp(light / next.exposure_s, range.gain_min, range.gain_max);
  return next;
}

}  // namespace polhode
