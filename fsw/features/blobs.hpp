// Blobs: where the difference of neighbouring blurs is extreme in place and scale.
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
  float contrast = 0.0F;  ///< of the extreme, absolute, gray levels of 255
  std::int32_t octave = 0;
};

/// The strongest blobs of each cell of a grid over the picture, strongest first: no bright corner
/// takes all places.
struct BlobGrid {
  static constexpr int kSide = 8;
  static constexpr std::size_t kPerCell =
      128;  ///< limits::kFeatures fit where the target is in 8 of the 64 cells
  using Cell = FixedVector<Blob, kPerCell>;
  std::array<Cell, kSide * kSide> cells{};
};

/// Three rows of each layer, at index y modulo 3.
struct LayerRows {
  using Row = std::array<float, limits::kWorkingSide + kRowGrain>;
  std::array<std::array<Row, 3>, ScaleSpace::kLevels - 1> layer{};
};

/// Finds blobs on the target, placed to a fraction of a pixel and of a layer.
/// @param contrast_min  gray levels of 255.
/// @source Lowe, IJCV 2004, sections 3 and 4: extremes among 26 neighbours, quadratic
/// interpolation, no edges.
void find_blobs(const ScaleSpace& space,
                const Region& region,
                float contrast_min,
                LayerRows* scratch,
                BlobGrid* grid);

}  // namespace polhode::sift
