#pragma once

#include <array>
#include <cstdint>

namespace polhode {

struct ShapeOptions {
  double outlier_radius_spacings = 4.0;  ///< radius of the outlier test in median point spacings, 1 .. 50
  int outlier_neighbours_min = 4;        ///< points with fewer neighbours in that radius are noise, 1 .. 100
  double voxel_spacings = 1.0;           ///< voxel edge in median point spacings, 0.2 .. 20
  double plane_inlier_min = 0.06;        ///< a plane holds at least this fraction of the points, 0.01 .. 1
  int plane_iterations_max = 500;        ///< 10 .. 10000
};

enum class ScaleSource : std::uint8_t { kNone, kKnownLength, kRange };

struct ScaleOptions {
  ScaleSource source = ScaleSource::kNone;
  double known_length_m = 0.0;                            ///< > 0 with kKnownLength
  std::array<std::array<double, 2>, 2> points_px{};       ///< its two ends (distorted pixels) in the frame named below
  double range_m = 0.0;                                   ///< > 0 with kRange: to the nearest surface on the boresight
  std::int64_t frame_timestamp_ns = 0;
};

}  // namespace polhode
