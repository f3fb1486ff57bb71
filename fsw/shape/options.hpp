#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace polhode {

// One line per option: tests/structure/test_parameters.py reads these lines.
// clang-format off
struct ShapeOptions {
  // Random points on a surface have 12 neighbours in this radius in the mean (see median_spacing), and under 4 with
  // probability 0.002 (Poisson). Larger keeps looser points.
  double outlier_radius_spacings = 4.0;  ///< radius of the outlier test in median point spacings, 1 .. 50
  int outlier_neighbours_min = 4;        ///< points with fewer neighbours in that radius are noise, 1 .. 100
  // One point a spacing: thins clumps only.
  double voxel_spacings = 1.0;           ///< voxel edge in median point spacings, 0.2 .. 20
  // Chosen; smaller finds smaller faces, and planes that are none.
  double plane_inlier_min = 0.06;        ///< a plane holds at least this fraction of the points, 0.01 .. 1
  // Three points of a plane come together with 99.9 % where it holds 24 %: ln(0.001) / ln(1 - 0.24^3) is 496.
  int plane_iterations_max = 500;        ///< hypotheses of one plane, 10 .. 10000
};

/// Where a scale comes from: a length between two image points, a range finder's reading, the
/// diameter of the cylinder or an edge of a flat face. Cylinder and face are found by the program.
enum class ScaleSource : std::uint8_t { kNone, kKnownLength, kRange, kDiameter, kEdge };
inline constexpr std::size_t kScaleSources = 4;  // all but kNone

/// 0: not given. Several may be given: they are combined by their sigmas.
struct ScaleOptions {
  double known_length_m = 0.0;                       ///< 0.001 .. 1000
  std::array<std::array<double, 2>, 2> points_px{};  ///< its two ends (distorted pixels) in the frame named below
  double range_m = 0.0;                              ///< to the nearest surface on the boresight, 0.01 .. 100000
  double range_sigma_m = 0.0;                        ///< 1-sigma of that reading, 0 .. 1000
  std::int64_t frame_timestamp_ns = 0;               ///< the frame that the length or the range belongs to
  double known_diameter_m = 0.0;                     ///< of the round body, 0.001 .. 1000
  double known_edge_m = 0.0;                         ///< longest edge of its flat faces, 0.001 .. 1000
};
// clang-format on

/// Whether any scale is given.
[[nodiscard]] inline bool any_given(const ScaleOptions& options) {
  return options.known_length_m != 0.0 || options.range_m != 0.0 ||
         options.known_diameter_m != 0.0 || options.known_edge_m != 0.0;
}

}  // namespace polhode
