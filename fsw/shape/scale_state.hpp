// Metres per map unit from all readings so far, and the readings that a configuration names.
#pragma once

#include <array>
#include <cstdint>

#include "geometry/camera_model.hpp"
#include "shape/scale.hpp"
#include "shape/scale_fusion.hpp"
#include "shape/shape.hpp"

namespace polhode {

/// State of the scale. It is unknown, with lengths in map units, without a reading or while
/// readings contradict each other.
struct ScaleState {
  bool known = false;
  double metres_per_mu = 1.0;
  double relative_sigma = 0.0;
  std::uint32_t keyframes_at_reading = 0;  ///< number of the map's next one at the last reading
  ScaleReadings readings;
  std::array<bool, kScaleSources> used{};  ///< readings that the scale comes from
  bool contradiction = false;
  std::uint32_t not_improved = 0;  ///< repeated readings that failed, or were no better
};

/// Result of a reading.
struct ScaleChange {
  bool read = false;                 ///< else nothing has changed
  bool contradiction_began = false;  ///< with this reading a contradiction began
};

/// Whether a length or a range is named in a frame.
[[nodiscard]] bool names_frame(const ScaleOptions& options);

/// Whether the map has grown by half since the last reading.
[[nodiscard]] bool has_grown(std::uint32_t next_keyframe, const ScaleState& scale);

/// Is a reading of the named length or range due? It is at first, and again when the map has grown
/// by half: a map of a few frames is bent, and its lengths are off by percents.
[[nodiscard]] bool frame_reading_is_due(const ScaleOptions& options,
                                        std::uint32_t next_keyframe,
                                        const ScaleState& scale);

/// Reads the named length and range in a view. Replaces their earlier readings.
ScaleChange read_scale_in(const ScaleView& view,
                          const ScaleOptions& options,
                          const CameraModel& camera,
                          std::uint32_t next_keyframe,
                          ScaleState* scale);

/// Reads the named diameter and edge in a found shape, in map units.
ScaleChange read_scale_of(const Shape& shape, const ScaleOptions& options, ScaleState* scale);

}  // namespace polhode
