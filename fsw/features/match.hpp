// Descriptor distances and matching.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "base/fixed_vector.hpp"
#include "features/detect.hpp"

namespace polhode {

/// Squared Euclidean distance. Inline and of constant length: within with_avx2() it is vectorised.
inline int distance2(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t i = 0; i < std::tuple_size_v<Descriptor>; ++i) {
    const int difference = static_cast<int>(a[i]) - static_cast<int>(b[i]);
    sum += difference * difference;
  }
  return sum;
}

// Largest squared distance of a match, for descriptors with norm 512 (kDescriptorNorm). Two views
// of one point 30 deg apart differ by about 200, unrelated textures by 500 to 600. 380 is in the
// middle between.
inline constexpr int kDistance2Max = 380 * 380;

/// Features binned into square cells for look-up by place.
class FeatureGrid {
 public:
  void build(std::span<const Feature> features, int width_px, int height_px);

  /// Indices of the features within `radius_px` of a pixel, at most the size of `out`, in index
  /// order by cell.
  std::size_t find(double u_px, double v_px, double radius_px, std::span<std::int32_t> out) const;

 private:
  /// Cells along each axis: about one cell a feature at limits::kFeatures.
  static constexpr int kCells = 32;

  /// Position of a feature, apart from the feature: the search then stays in the cache.
  struct Place {
    float u_px = 0.0F;
    float v_px = 0.0F;
    std::int32_t feature = -1;
  };

  [[nodiscard]] int cell_of(double position_px, double size_px) const;

  double width_px_ = 1.0;
  double height_px_ = 1.0;
  std::array<std::int32_t, kCells * kCells + 1> first_{};
  std::array<Place, limits::kFeatures> places_{};  ///< cell by cell
};

/// Nearest feature by descriptor, and the distance of the next one at another place.
struct NearestFeature {
  std::int32_t feature = -1;
  int nearest2 = std::numeric_limits<int>::max();
  int rival2 = std::numeric_limits<int>::max();
};

inline bool same_place(const Feature& a, const Feature& b, float within_px) {
  const float du = a.u_px - b.u_px;
  const float dv = a.v_px - b.v_px;
  return du * du + dv * dv < within_px * within_px;
}

/// Compares one more of `among`, at squared distance `d2`; of equals the first one stays. A blob
/// with two orientations gives two features at one place (`same_px`), which are no rivals. Inline:
/// as distance2().
inline void keep_nearest(std::int32_t feature,
                         int d2,
                         std::span<const Feature> among,
                         float same_px,
                         NearestFeature* best) {
  const auto is_same_blob = [&] {
    return best->feature >= 0 && same_place(among[static_cast<std::size_t>(feature)],
                                            among[static_cast<std::size_t>(best->feature)],
                                            same_px);
  };
  if (d2 < best->nearest2) {
    if (!is_same_blob()) {
      best->rival2 = best->nearest2;
    }
    best->nearest2 = d2;
    best->feature = feature;
  } else if (d2 < best->rival2 && !is_same_blob()) {
    best->rival2 = d2;
  }
}

struct FeatureMatch {
  std::int32_t a = -1;
  std::int32_t b = -1;
  int distance2 = 0;
};

using FeatureMatches = FixedVector<FeatureMatch, limits::kFeatures>;

/// Matches that are each other's nearest, with the second nearest (at another place, over a pixel
/// away) farther by the ratio. Exhaustive.
void match_mutual(std::span<const Feature> a,
                  std::span<const Feature> b,
                  double ratio_max,
                  FeatureMatches* matches);

}  // namespace polhode
