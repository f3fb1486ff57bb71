// How a sensor answers light, exposure and gain: in proportion, up to its full scale.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hil/v4l2/filecam/feed_format.h"

namespace {

/// Eight bits. A setting takes effect two frames after it is made, as with most sensors.
class Sensor {
 public:
  double light = 1.0;  ///< level of a pixel over the sequence's, at 10 ms and least gain

  void expose(const filecam_state& state, std::span<std::uint8_t> pixels) {
    std::rotate(settings_.begin(), settings_.begin() + 1, settings_.end());
    settings_.back() = {.exposure_100us = state.exposure_100us, .gain = state.gain};
    if (frames_++ == 0) {
      settings_.fill(settings_.back());
    }
    const Setting& now = settings_.front();
    const double factor = light * 0.01 * now.exposure_100us *
                          (1.0 + (kGainFactorMax - 1.0) * now.gain / FILECAM_GAIN_MAX);
    std::array<std::size_t, 256> levels{};
    for (std::uint8_t& pixel : pixels) {
      const double level = std::min(255.0, factor * pixel + 0.5);
      pixel = static_cast<std::uint8_t>(level);
      ++levels[pixel];
    }
    saturated_ = levels[255];
    bright_ = bright_level(levels, pixels.size());
  }

  /// "EXPOSURE_US GAIN LIGHT BRIGHT SATURATED": as they were for this frame; level that a fiftieth
  /// of the pixels that are not black exceeds, and pixels at full scale.
  [[nodiscard]] std::string account() const {
    const Setting& now = settings_.front();
    return fmt::format(
        "{} {} {} {} {}", 100 * now.exposure_100us, now.gain, light, bright_, saturated_);
  }

 private:
  struct Setting {
    std::uint32_t exposure_100us = 0;
    std::uint32_t gain = 0;
  };
  static constexpr double kGainFactorMax =
      16.0;  // as the live run takes it (device.gain_factor_max)

  static std::size_t bright_level(const std::array<std::size_t, 256>& levels, std::size_t pixels) {
    const std::size_t beyond = (pixels - levels[0]) / 50;
    std::size_t level = 255;
    for (std::size_t above = levels[level]; above <= beyond && level > 0; above += levels[level]) {
      --level;
    }
    return level;
  }

  std::array<Setting, 3> settings_{};  ///< the oldest is in force
  std::size_t frames_ = 0;
  std::size_t bright_ = 0;
  std::size_t saturated_ = 0;
};

}  // namespace
