// Blobs: where the difference of neighbouring blur levels is extreme in position and scale.
#pragma once

#include <array>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "features/region.hpp"
#include "features/scale_space.hpp"

namespace polhode::sift {

struct Blob {
  float x = 0.0F;  ///< pixels of its octave
  float y = 0.0F;
  float level = 0.0F;  ///< within the octave: sigma_of_level() is its size in pixels of the octave
  float contrast = 0.0F;  ///< of the extremum, absolute, gray levels of 255
  std::int32_t octave = 0;
};

/// The strongest blobs of each cell of a grid over the image, strongest first. So no bright
/// corner takes all features.
struct BlobGrid {
  /// 64 cells: 12 or 13 of the default 800 features each. Chosen: more cells spread features more
  /// evenly and take weaker ones.
  static constexpr int kSide = 8;
  /// limits::kFeatures fit where the target is in 8 of the 64 cells.
  static constexpr std::size_t kPerCell = 128;
  using Cell = FixedVector<Blob, kPerCell>;
  std::array<Cell, kSide * kSide> cells{};
};

/// Three rows of each layer, at index y modulo 3.
struct LayerRows {
  using Row = std::array<float, limits::kWorkingSide + kRowGrain>;
  std::array<std::array<Row, 3>, ScaleSpace::kLevels - 1> layer{};
};

/// Finds blobs on the target, interpolated in position and scale.
/// @param contrast_min  gray levels of 255.
/// @source Lowe, IJCV 2004, sections 3 and 4: extrema among 26 neighbours, quadratic
/// interpolation, no edges.
void find_blobs(const ScaleSpace& space,
                const Region& region,
                float contrast_min,
                LayerRows* scratch,
                BlobGrid* grid);

}  // namespace polhode::sift
