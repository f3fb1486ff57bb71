#include "pipeline/scale_now.hpp"

#include <algorithm>
#include <optional>

#include "shape/scale.hpp"
#include "shape/scale_of_shape.hpp"

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

/// Nothing was read from the named frame yet, or the map has grown by half since.
bool is_due(const Component::State& s) {
  const ScaleOptions& options = s.parameters.scale;
  const auto lacks = [&s](ScaleSource source) {
    return std::none_of(s.scale.readings.begin(),
                        s.scale.readings.end(),
                        [source](const ScaleReading& reading) { return reading.source == source; });
  };
  return (options.known_length_m != 0.0 && lacks(ScaleSource::kKnownLength)) ||
         (options.range_m != 0.0 && lacks(ScaleSource::kRange)) ||
         2 * s.map.next_keyframe_number >= 3 * s.scale.keyframes_at_reading;
}

ScaleReadings readings_beside(ScaleSource source, const ScaleReadings& all) {
  ScaleReadings others;
  for (const ScaleReading& reading : all) {
    if (reading.source != source) {
      (void)take_reading(reading, others);
    }
  }
  return others;
}

/// What the readings together say.
void settle(Component::State* s) {
  ScaleState& scale = s->scale;
  const FusedScale fused = fuse_scales(scale.readings);
  if (fused.contradiction && !scale.contradiction) {
    ++s->counters.scale_contradictions;
  }
  scale.contradiction = fused.contradiction;
  scale.used = fused.used;
  scale.known = fused.known;
  scale.metres_per_mu = fused.known ? fused.metres_per_mu : 1.0;
  scale.relative_sigma = fused.known ? fused.sigma / fused.metres_per_mu : 0.0;
  scale.metres_per_mu_published = fused.known ? fused.metres_per_mu : scale.metres_per_mu_published;
}

bool take(ScaleSource source, const Result<ScaleEstimate>& estimate, Component::State* s) {
  if (!estimate) {
    return false;
  }
  const ScaleReading reading{.source = source,
                             .metres_per_mu = estimate.value().metres_per_mu,
                             .sigma = estimate.value().sigma};
  return take_reading(reading, s->scale.readings);
}

/// The named length and range, in place of what an earlier view said of them.
bool measure_scale_in(const ScaleView& view, Component::State* s) {
  const ScaleOptions& options = s->parameters.scale;
  bool taken = false;
  if (options.known_length_m != 0.0) {
    const auto ray = [&](std::size_t end) {
      return undistort(s->camera, {options.points_px[end][0], options.points_px[end][1]});
    };
    // A point picked in a picture by a person or an edge finder is good to a pixel.
    const double sigma_ray = 1.0 / s->camera.focal_px();
    taken |= take(ScaleSource::kKnownLength,
                  scale_from_length(view, ray(0), ray(1), options.known_length_m, sigma_ray),
                  s);
  }
  if (options.range_m != 0.0) {
    taken |= take(
        ScaleSource::kRange, scale_from_range(view, options.range_m, options.range_sigma_m), s);
  }
  if (taken) {
    // One that is no longer asked for has been replaced.
    ScaleReadings& readings = s->scale.readings;
    if (options.known_length_m == 0.0) {
      readings = readings_beside(ScaleSource::kKnownLength, readings);
    }
    if (options.range_m == 0.0) {
      readings = readings_beside(ScaleSource::kRange, readings);
    }
    s->scale.keyframes_at_reading = s->map.next_keyframe_number;
    settle(s);
  }
  return taken;
}

}  // namespace

bool names_frame(const ScaleOptions& options) {
  return options.known_length_m != 0.0 || options.range_m != 0.0;
}

void forget_scale(Component::State* s) {
  const double published = s->scale.metres_per_mu_published;
  s->scale = {};
  s->scale.metres_per_mu_published = published;
}

bool measure_scale_of(const Shape& shape, Component::State* s) {
  const ScaleOptions& options = s->parameters.scale;
  bool taken = false;
  if (options.known_diameter_m != 0.0) {
    taken |= take(ScaleSource::kDiameter, scale_from_diameter(shape, options.known_diameter_m), s);
  }
  if (options.known_edge_m != 0.0) {
    const FusedScale others = fuse_scales(readings_beside(ScaleSource::kEdge, s->scale.readings));
    taken |=
        take(ScaleSource::kEdge,
             scale_from_edge(shape,
                             options.known_edge_m,
                             others.known ? std::optional(others.metres_per_mu) : std::nullopt),
             s);
  }
  if (taken) {
    settle(s);
  }
  return taken;
}

bool measure_scale_in_keyframe(Component::State* s) {
  const std::int64_t wanted_ns = s->parameters.scale.frame_timestamp_ns;
  for (const Keyframe& keyframe : s->map.keyframes) {
    if (keyframe.used && keyframe.timestamp_ns == wanted_ns) {
      return measure_scale_in({.pose = keyframe.pose, .landmarks_T = seen_in(keyframe, s->map).view()}, s);
    }
  }
  return false;
}

bool measure_scale_in_frame(Component::State* s) {
  return measure_scale_in(
      {.pose = s->localised.absolute.pose, .landmarks_T = seen_in_this_frame(*s).view()}, s);
}

void measure_scale(Component::State* s) {
  const ScaleOptions& options = s->parameters.scale;
  if (!s->pose_valid || !names_frame(options) || !is_due(*s)) {
    return;
  }
  if (s->timestamp_ns == options.frame_timestamp_ns) {
    (void)measure_scale_in_frame(s);
  } else {
    (void)measure_scale_in_keyframe(s);
  }
}

}  // namespace polhode
