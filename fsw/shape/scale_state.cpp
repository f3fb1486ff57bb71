#include "shape/scale_state.hpp"

#include <algorithm>
#include <optional>

#include "shape/scale_of_shape.hpp"

namespace polhode {
namespace {

ScaleReadings readings_beside(ScaleSource source, const ScaleReadings& all) {
  ScaleReadings others;
  for (const ScaleReading& reading : all) {
    if (reading.source != source) {
      (void)add_reading(reading, others);
    }
  }
  return others;
}

/// Updates the scale from all readings.
ScaleChange settle(ScaleState* scale) {
  const FusedScale fused = fuse_scales(scale->readings);
  const ScaleChange change{.read = true,
                           .contradiction_began = fused.contradiction && !scale->contradiction};
  scale->contradiction = fused.contradiction;
  scale->used = fused.used;
  scale->known = fused.known;
  scale->metres_per_mu = fused.known ? fused.metres_per_mu : 1.0;
  scale->relative_sigma = fused.known ? fused.sigma / fused.metres_per_mu : 0.0;
  return change;
}

bool take(ScaleSource source, const Result<ScaleEstimate>& estimate, ScaleReadings& readings) {
  if (!estimate) {
    return false;
  }
  const ScaleReading reading{.source = source,
                             .metres_per_mu = estimate.value().metres_per_mu,
                             .sigma = estimate.value().sigma};
  return add_reading(reading, readings);
}

}  // namespace

bool names_frame(const ScaleOptions& options) {
  return options.known_length_m != 0.0 || options.range_m != 0.0;
}

bool has_grown(std::uint32_t next_keyframe, const ScaleState& scale) {
  return 2 * next_keyframe >= 3 * scale.keyframes_at_reading;  // grown by half (decision 0057)
}

bool frame_reading_is_due(const ScaleOptions& options,
                          std::uint32_t next_keyframe,
                          const ScaleState& scale) {
  const auto lacks = [&scale](ScaleSource source) {
    return std::none_of(scale.readings.begin(),
                        scale.readings.end(),
                        [source](const ScaleReading& reading) { return reading.source == source; });
  };
  return (options.known_length_m != 0.0 && lacks(ScaleSource::kKnownLength)) ||
         (options.range_m != 0.0 && lacks(ScaleSource::kRange)) || has_grown(next_keyframe, scale);
}

ScaleChange read_scale_in(const ScaleView& view,
                          const ScaleOptions& options,
                          const CameraModel& camera,
                          std::uint32_t next_keyframe,
                          ScaleState* scale) {
  ScaleReadings& readings = scale->readings;
  bool taken = false;
  if (options.known_length_m != 0.0) {
    const auto ray = [&](std::size_t end) {
      return undistort(camera, {options.points_px[end][0], options.points_px[end][1]});
    };
    // 1-sigma of a point picked in an image, a pixel (decision 0057)
    const double sigma_ray = 1.0 / camera.focal_px();
    taken |= take(ScaleSource::kKnownLength,
                  scale_from_length(view, ray(0), ray(1), options.known_length_m, sigma_ray),
                  readings);
  }
  if (options.range_m != 0.0) {
    taken |= take(ScaleSource::kRange,
                  scale_from_range(view, options.range_m, options.range_sigma_m),
                  readings);
  }
  if (taken) {
    // Drops readings that the options no longer name.
    if (options.known_length_m == 0.0) {
      readings = readings_beside(ScaleSource::kKnownLength, readings);
    }
    if (options.range_m == 0.0) {
      readings = readings_beside(ScaleSource::kRange, readings);
    }
    scale->keyframes_at_reading = next_keyframe;
    return settle(scale);
  }
  return {};
}

ScaleChange read_scale_of(const Shape& shape, const ScaleOptions& options, ScaleState* scale) {
  bool taken = false;
  if (options.known_diameter_m != 0.0) {
    taken |= take(ScaleSource::kDiameter,
                  scale_from_diameter(shape, options.known_diameter_m),
                  scale->readings);
  }
  if (options.known_edge_m != 0.0) {
    const FusedScale others = fuse_scales(readings_beside(ScaleSource::kEdge, scale->readings));
    taken |=
        take(ScaleSource::kEdge,
             scale_from_edge(shape,
                             options.known_edge_m,
                             others.known ? std::optional(others.metres_per_mu) : std::nullopt),
             scale->readings);
  }
  return taken ? settle(scale) : ScaleChange{};
}

}  // namespace polhode
