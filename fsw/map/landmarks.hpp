// Creation of landmarks from pairs of keyframes, their extension and culling.
#pragma once

#include <cstdint>

#include "geometry/camera_model.hpp"
#include "map/map.hpp"
#include "map/options.hpp"

namespace polhode {

struct CreateOptions {
  double parallax_min_rad = 0.035;
  double ratio_max = 0.8;
};

/// Free features of a partner in the layout of a search along epipolar lines: a column a quantity.
struct LineTable {
  /// Doubles of a 512-bit register: columns are padded to a multiple of it.
  static constexpr std::size_t kGrain = 8;
  using Column = std::array<double, (limits::kFeatures + kGrain - 1) / kGrain * kGrain>;
  Column x{};  ///< normalised
  Column y{};
  Column variance{};   ///< normalised
  Column gradient2{};  ///< of the epipolar line in the keyframe itself: squared slope of the error
  FixedVector<std::int32_t, limits::kFeatures> near;  ///< rows within a line's gate
};

/// Working memory; contents mean nothing between calls.
struct CreateScratch {
  FixedVector<std::int32_t, limits::kFeatures> taken;  ///< features with a landmark, by u
  FixedVector<std::int32_t, limits::kFeatures> free_a;
  FixedVector<std::int32_t, limits::kFeatures> free_b;
  LineTable lines;  ///< row k is free_b[k]
  std::array<std::int32_t, limits::kFeatures> best_of_b{};
  std::array<std::int32_t, limits::kFeatures> distance_of_b{};
};

/// Matches the free features of `keyframe` along the epipolar lines in up to four partner
/// keyframes, triangulates, searches for the point in further keyframes, and keeps points that
/// agree with all of them within chi-square.
/// @return landmarks made.
int create_landmarks(KeyframeId keyframe,
                     const CreateOptions& options,
                     const CameraModel& camera,
                     CreateScratch* scratch,
                     Map* map);

/// Associates landmarks with free features of keyframes in which they should be seen: within 3
/// sigma and alike in appearance. Done for the landmarks numbered `first_number` and up, in all
/// keyframes that face them.
/// @return observations added.
int extend_landmarks(std::int32_t first_number, const CameraModel& camera, Map* map);

/// Drops observations whose reprojection error exceeds kInlierChi2 by the noise scale, then removes
/// landmarks seen by fewer than two keyframes, those still seen by only two when three keyframes
/// have come since, and those found in under a quarter of the frames that should have seen them.
/// @return landmarks removed.
int cull_landmarks(const CameraModel& camera, double noise_scale, Map* map);

/// Robust scale of the observations' residuals in units of their sigma (median of squares over its
/// value for a unit normal).
double residual_scale(const Map& map, const CameraModel& camera);

}  // namespace polhode
