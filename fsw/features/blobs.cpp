#include "features/blobs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/assert.hpp"
#include "features/lanes.hpp"

namespace polhode::sift {
namespace {

using Octave = std::array<Plane, ScaleSpace::kLevels>;

// Contrast of a pixel over the least contrast of a blob. An extremum's interpolated height seldom
// exceeds its pixel's by more. Chosen: larger loses weak blobs, smaller refines in vain.
constexpr float kPixelShare = 0.6F;

/// Image border left out. Differences need 1 px; the rest keeps away from mirrored blur. Chosen.
constexpr int kMargin_px = 4;

/// Difference of two neighbouring levels.
float layer_at(const Octave& octave, int layer, int y, int x) {
  return octave[static_cast<std::size_t>(layer) + 1].row(y)[x] -
         octave[static_cast<std::size_t>(layer)].row(y)[x];
}

template <class Lanes>
void fill_row(const Octave& octave, int y, LayerRows* rows) {
  for (std::size_t i = 0; i + 1 < ScaleSpace::kLevels; ++i) {
    const float* fine = octave[i].row(y);
    const float* coarse = octave[i + 1].row(y);
    float* out = rows->layer[i][static_cast<std::size_t>(y % 3)].data();
    for (int x = 0; x < octave[i].width; x += kLanes<Lanes>) {
      store(load<Lanes>(coarse + x) - load<Lanes>(fine + x), out + x);
    }
  }
}

/// The rows above, at and below y of a layer.
using ThreeRows = std::array<const float*, 3>;

ThreeRows three_rows(const LayerRows& rows, int layer, int y) {
  ThreeRows three{};
  for (int i = 0; i < 3; ++i) {
    three[static_cast<std::size_t>(i)] =
        rows.layer[static_cast<std::size_t>(layer)][static_cast<std::size_t>((y + i - 1) % 3)]
            .data();
  }
  return three;
}

template <class Lanes>
struct Range {
  Lanes least;
  Lanes most;
};

template <class Lanes>
Range<Lanes> range_of(const float* a, const float* b, const float* c, const float* d) {
  const Lanes first = load<Lanes>(a);
  const Lanes second = load<Lanes>(b);
  const Lanes third = load<Lanes>(c);
  const Lanes fourth = load<Lanes>(d);
  return {.least = smaller(smaller(first, second), smaller(third, fourth)),
          .most = larger(larger(first, second), larger(third, fourth))};
}

/// Lanes that may still contain an extremum.
template <class Lanes>
struct Extremes {
  LaneMask<Lanes> high;
  LaneMask<Lanes> low;
  [[nodiscard]] LaneMask<Lanes> either() const { return high | low; }
};

/// Lanes from x on that are beyond the threshold and extreme among their eight neighbours in the
/// layer. Of equal pixels the last one counts.
template <class Lanes>
Extremes<Lanes> extreme_in_layer(const ThreeRows& rows, int x, Lanes threshold) {
  const Lanes middle = load<Lanes>(rows[1] + x);
  Extremes<Lanes> found{.high = middle > threshold, .low = middle < -threshold};
  if (!any(found.either())) {
    return found;
  }
  const auto before =
      range_of<Lanes>(rows[0] + x - 1, rows[0] + x, rows[0] + x + 1, rows[1] + x - 1);
  const auto after =
      range_of<Lanes>(rows[1] + x + 1, rows[2] + x - 1, rows[2] + x, rows[2] + x + 1);
  found.high &= (middle >= before.most) & (middle > after.most);
  found.low &= (middle <= before.least) & (middle < after.least);
  return found;
}

/// Keeps the lanes that are extreme among the 3 x 3 pixels around them in a neighbouring layer.
template <class Lanes>
void keep_unbeaten(Lanes middle, const ThreeRows& rows, int x, Extremes<Lanes>* found) {
  for (const float* row : rows) {
    for (int i = -1; i <= 1; ++i) {
      const Lanes other = load<Lanes>(row + x + i);
      found->high &= other <= middle;
      found->low &= other >= middle;
    }
  }
}

/// First and second differences of the layers at a pixel: x, y, layer.
struct Slopes {
  float g[3];
  float h_xx, h_yy, h_ss, h_xy, h_xs, h_ys;
};

Slopes slopes_at(const Octave& octave, int layer, int y, int x) {
  const auto d = [&](int ds, int dy, int dx) {
    return layer_at(octave, layer + ds, y + dy, x + dx);
  };
  const float twice = 2.0F * d(0, 0, 0);
  return {.g = {0.5F * (d(0, 0, 1) - d(0, 0, -1)),
                0.5F * (d(0, 1, 0) - d(0, -1, 0)),
                0.5F * (d(1, 0, 0) - d(-1, 0, 0))},
          .h_xx = d(0, 0, 1) + d(0, 0, -1) - twice,
          .h_yy = d(0, 1, 0) + d(0, -1, 0) - twice,
          .h_ss = d(1, 0, 0) + d(-1, 0, 0) - twice,
          .h_xy = 0.25F * (d(0, 1, 1) - d(0, 1, -1) - d(0, -1, 1) + d(0, -1, -1)),
          .h_xs = 0.25F * (d(1, 0, 1) - d(1, 0, -1) - d(-1, 0, 1) + d(-1, 0, -1)),
          .h_ys = 0.25F * (d(1, 1, 0) - d(1, -1, 0) - d(-1, 1, 0) + d(-1, -1, 0))};
}

/// Extremum of the quadratic with these derivatives, by Cramer's rule.
std::optional<std::array<float, 3>> extreme_of(const Slopes& s) {
  const float c_xx = s.h_yy * s.h_ss - s.h_ys * s.h_ys;
  const float c_xy = s.h_xs * s.h_ys - s.h_xy * s.h_ss;
  const float c_xs = s.h_xy * s.h_ys - s.h_xs * s.h_yy;
  const float c_yy = s.h_xx * s.h_ss - s.h_xs * s.h_xs;
  const float c_ys = s.h_xy * s.h_xs - s.h_xx * s.h_ys;
  const float c_ss = s.h_xx * s.h_yy - s.h_xy * s.h_xy;
  const float determinant = s.h_xx * c_xx + s.h_xy * c_xy + s.h_xs * c_xs;
  if (determinant == 0.0F) {
    return std::nullopt;
  }
  const float scale = -1.0F / determinant;
  return std::array<float, 3>{scale * (c_xx * s.g[0] + c_xy * s.g[1] + c_xs * s.g[2]),
                              scale * (c_xy * s.g[0] + c_yy * s.g[1] + c_ys * s.g[2]),
                              scale * (c_xs * s.g[0] + c_ys * s.g[1] + c_ss * s.g[2])};
}

/// A blob on an edge is placed across it only: its principal curvatures differ (Lowe, section 4.1).
bool is_edge(const Slopes& s) {
  constexpr float kRatio = 10.0F;  // Lowe's
  const float trace = s.h_xx + s.h_yy;
  const float determinant = s.h_xx * s.h_yy - s.h_xy * s.h_xy;
  return determinant <= 0.0F ||
         trace * trace * kRatio >= (kRatio + 1.0F) * (kRatio + 1.0F) * determinant;
}

/// Interpolates around a pixel. Moves to the neighbour in which the extremum lies.
std::optional<Blob> refine(const Octave& octave, int layer, int y, int x, float contrast_min) {
  constexpr int kSteps = 5;  // as OpenCV's SIFT
  for (int step = 0; step < kSteps; ++step) {
    const Slopes s = slopes_at(octave, layer, y, x);
    const auto offset = extreme_of(s);
    // Beyond it the quadratic does not describe the neighbourhood. Chosen.
    constexpr float kFar = 3.0F;
    if (!offset || std::abs((*offset)[0]) > kFar || std::abs((*offset)[1]) > kFar ||
        std::abs((*offset)[2]) > kFar) {
      return std::nullopt;
    }
    const auto [dx, dy, ds] = *offset;
    constexpr float kHalf = 0.5F;  // within it no neighbour is nearer
    if (std::abs(dx) < kHalf && std::abs(dy) < kHalf && std::abs(ds) < kHalf) {
      const float height =
          layer_at(octave, layer, y, x) + 0.5F * (s.g[0] * dx + s.g[1] * dy + s.g[2] * ds);
      if (std::abs(height) < contrast_min || is_edge(s)) {
        return std::nullopt;
      }
      return Blob{.x = static_cast<float>(x) + dx,
                  .y = static_cast<float>(y) + dy,
                  .level = static_cast<float>(layer) + ds,
                  .contrast = std::abs(height)};
    }
    x += static_cast<int>(std::lround(dx));
    y += static_cast<int>(std::lround(dy));
    layer += static_cast<int>(std::lround(ds));
    if (layer < 1 || layer > ScaleSpace::kLayers || x < kMargin_px ||
        x >= octave[0].width - kMargin_px || y < kMargin_px || y >= octave[0].height - kMargin_px) {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

/// Keeps the cell sorted; a full one drops its weakest blob. Two pixels may converge to one
/// extremum, which is kept once.
void insert(const Blob& blob, BlobGrid::Cell* cell) {
  if (cell->full() && cell->back().contrast >= blob.contrast) {
    return;
  }
  std::size_t place = cell->size();
  while (place > 0 && (*cell)[place - 1].contrast < blob.contrast) {
    --place;
  }
  if (place > 0) {
    const Blob& same = (*cell)[place - 1];
    if (same.contrast == blob.contrast && same.x == blob.x && same.y == blob.y &&
        same.octave == blob.octave) {
      return;
    }
  }
  if (cell->full()) {
    cell->pop_back();
  }
  (void)cell->push_back(blob);
  for (std::size_t i = cell->size() - 1; i > place; --i) {
    (*cell)[i] = (*cell)[i - 1];
  }
  (*cell)[place] = blob;
}

void keep(const Blob& blob, const Region& region, BlobGrid* grid) {
  const auto scale = static_cast<float>(1 << blob.octave);
  const float x = blob.x * scale;
  const float y = blob.y * scale;
  if (!region.on_target(static_cast<double>(x), static_cast<double>(y))) {
    return;
  }
  const auto place = [](float at, int size) {
    return std::clamp(
        static_cast<int>(at * BlobGrid::kSide / static_cast<float>(size)), 0, BlobGrid::kSide - 1);
  };
  const int cell = place(y, region.size.height) * BlobGrid::kSide + place(x, region.size.width);
  insert(blob, &grid->cells[static_cast<std::size_t>(cell)]);
}

struct Search {
  const Region& region;
  float contrast_min;
  BlobGrid* grid;
};

template <class Lanes>
void search_row(
    const Octave& octave, std::int32_t number, const LayerRows& rows, int y, const Search& search) {
  const Lanes threshold = splat<Lanes>(kPixelShare * search.contrast_min);
  const int end = octave[0].width - kMargin_px;
  for (int layer = 1; layer <= ScaleSpace::kLayers; ++layer) {
    const ThreeRows here = three_rows(rows, layer, y);
    const ThreeRows finer = three_rows(rows, layer - 1, y);
    const ThreeRows coarser = three_rows(rows, layer + 1, y);
    for (int x = kMargin_px; x < end; x += kLanes<Lanes>) {
      Extremes<Lanes> found = extreme_in_layer(here, x, threshold);
      if (!any(found.either())) {
        continue;
      }
      const Lanes middle = load<Lanes>(here[1] + x);
      keep_unbeaten(middle, finer, x, &found);
      keep_unbeaten(middle, coarser, x, &found);
      const LaneMask<Lanes> left = found.either();
      for (int lane = 0; any(left) && lane < std::min(kLanes<Lanes>, end - x); ++lane) {
        if (left[lane] == 0) {
          continue;
        }
        if (auto blob = refine(octave, layer, y, x + lane, search.contrast_min)) {
          blob->octave = number;
          keep(*blob, search.region, search.grid);
        }
      }
    }
  }
}

template <class Lanes>
void search_octave(const Octave& octave,
                   std::int32_t number,
                   LayerRows* rows,
                   const Search& search) {
  fill_row<Lanes>(octave, kMargin_px - 1, rows);
  fill_row<Lanes>(octave, kMargin_px, rows);
  for (int y = kMargin_px; y < octave[0].height - kMargin_px; ++y) {
    fill_row<Lanes>(octave, y + 1, rows);
    search_row<Lanes>(octave, number, *rows, y, search);
  }
}

}  // namespace

void find_blobs(const ScaleSpace& space,
                const Region& region,
                float contrast_min,
                LayerRows* scratch,
                BlobGrid* grid) {
  for (BlobGrid::Cell& cell : grid->cells) {
    cell.clear();
  }
  const Search search{.region = region, .contrast_min = contrast_min, .grid = grid};
  for (int o = 0; o < space.octaves; ++o) {
    const Octave& octave = space.level[static_cast<std::size_t>(o)];
    with_lanes([&](auto kind) {
      search_octave<typename decltype(kind)::Lanes>(octave, o, scratch, search);
    });
  }
}

}  // namespace polhode::sift
