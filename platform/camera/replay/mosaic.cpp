#include "camera/replay/mosaic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

namespace polhode::platform {
namespace {

constexpr unsigned kLitPart = 16;  // darker than this part of the largest level is noise
constexpr int kTiles = 8;          // along each edge
constexpr std::size_t kTilePixelsMin = 128;
constexpr std::size_t kTilesMin = 4;
// Texture is as often brighter in one cell as in the other; a mosaic has its order everywhere, or
// nearly so where the body has several colours.
constexpr double kAgreeingMin = 0.75;

/// Sums of the lit pixels of one tile, by their place in the cells of 2x2.
struct Tile {
  MosaicCells above_mean{};  ///< level less the mean around it
  MosaicCells mean{};
  std::size_t pixels = 0;
};

/// Levels of either depth by row and column.
class Levels {
 public:
  explicit Levels(const DecodedImage& image)
      : image_(image), bytes_(image.header.format == PixelFormat::kGray16 ? 2 : 1) {}

  [[nodiscard]] unsigned at(int u, int v) const {
    const auto place = static_cast<std::size_t>(v) * static_cast<std::size_t>(width()) +
                       static_cast<std::size_t>(u);
    if (bytes_ == 1) {
      return image_.pixels[place];
    }
    std::uint16_t level = 0;
    std::memcpy(&level, &image_.pixels[2 * place], sizeof level);
    return level;
  }
  /// Of the nine pixels around a place inside the image, 1-2-1 both ways, times 16.
  [[nodiscard]] unsigned around(int u, int v) const {
    return along(u, v - 1) + 2 * along(u, v) + along(u, v + 1);
  }
  [[nodiscard]] unsigned largest() const {
    unsigned largest = 0;
    for (int v = 0; v < height(); ++v) {
      for (int u = 0; u < width(); ++u) {
        largest = std::max(largest, at(u, v));
      }
    }
    return largest;
  }
  [[nodiscard]] int width() const { return image_.header.width_px; }
  [[nodiscard]] int height() const { return image_.header.height_px; }

 private:
  [[nodiscard]] unsigned along(int u, int v) const {
    return at(u - 1, v) + 2 * at(u, v) + at(u + 1, v);
  }

  const DecodedImage& image_;
  int bytes_;
};

/// Of an image; u and v are even and at least 2, as around() reaches one pixel out.
struct Part {
  int u, v, width, height;
};

Tile tile_at(const Levels& levels, const Part& part, unsigned lit) {
  Tile tile;
  for (int v = part.v; v < part.v + part.height; ++v) {
    for (int u = part.u; u < part.u + part.width; ++u) {
      const unsigned around = levels.around(u, v);
      if (around > 16 * lit) {
        const auto cell = static_cast<std::size_t>(2 * (v % 2) + u % 2);
        const double mean = around / 16.0;
        tile.above_mean[cell] += levels.at(u, v) - mean;
        tile.mean[cell] += mean;
        ++tile.pixels;
      }
    }
  }
  return tile;
}

/// Those with enough lit pixels.
std::vector<Tile> tiles_of(const Levels& levels) {
  std::vector<Tile> tiles;
  const int width = (levels.width() - 4) / kTiles / 2 * 2;
  const int height = (levels.height() - 4) / kTiles / 2 * 2;
  const unsigned lit = levels.largest() / kLitPart;
  for (int i = 0; width > 0 && height > 0 && i < kTiles * kTiles; ++i) {
    const Part part{2 + i % kTiles * width, 2 + i / kTiles * height, width, height};
    const Tile tile = tile_at(levels, part, lit);
    if (tile.pixels >= kTilePixelsMin) {
      tiles.push_back(tile);
    }
  }
  return tiles;
}

MosaicCells relative_cells(const std::vector<Tile>& tiles) {
  MosaicCells above_mean{};
  MosaicCells mean{};
  for (const Tile& tile : tiles) {
    for (std::size_t cell = 0; cell < above_mean.size(); ++cell) {
      above_mean[cell] += tile.above_mean[cell];
      mean[cell] += tile.mean[cell];
    }
  }
  for (std::size_t cell = 0; cell < above_mean.size(); ++cell) {
    above_mean[cell] = mean[cell] > 0.0 ? above_mean[cell] / mean[cell] : 0.0;
  }
  return above_mean;
}

/// Sums along the row, four times the level; beyond its ends the row is mirrored at its last pixel.
template <typename Sample>
void sum_along(const std::uint8_t* row, int width, std::vector<std::uint32_t>* sums) {
  const auto level = [row](int u) {
    Sample sample = 0;
    std::memcpy(&sample, row + static_cast<std::size_t>(u) * sizeof sample, sizeof sample);
    return std::uint32_t{sample};
  };
  for (int u = 0; u < width; ++u) {
    const int left = u > 0 ? u - 1 : 1;
    const int right = u + 1 < width ? u + 1 : width - 2;
    (*sums)[static_cast<std::size_t>(u)] = level(left) + 2 * level(u) + level(right);
  }
}

}  // namespace

double contrast_of(const MosaicCells& cells) {
  const auto [darkest, brightest] = std::minmax_element(cells.begin(), cells.end());
  return *brightest - *darkest;
}

std::optional<MosaicCells> mosaic_of(const DecodedImage& image) {
  const std::vector<Tile> tiles = tiles_of(Levels(image));
  if (tiles.size() < kTilesMin) {
    return std::nullopt;
  }
  const MosaicCells cells = relative_cells(tiles);
  const auto [darkest, brightest] = std::minmax_element(cells.begin(), cells.end());
  const auto dark = static_cast<std::size_t>(darkest - cells.begin());
  const auto bright = static_cast<std::size_t>(brightest - cells.begin());
  const auto agreeing = std::count_if(tiles.begin(), tiles.end(), [&](const Tile& tile) {
    return tile.above_mean[bright] > tile.above_mean[dark];
  });
  const bool everywhere =
      static_cast<double>(agreeing) >= kAgreeingMin * static_cast<double>(tiles.size());
  return everywhere && contrast_of(cells) >= kMosaicContrastMin ? std::optional(cells)
                                                                : std::nullopt;
}

std::string mosaic_remark(double contrast, MosaicChoice choice) {
  return fmt::format(
      "neighbouring pixels differ by {:.0f} % of the level, as in the mosaic of a colour sensor "
      "(Bayer); {}",
      100.0 * contrast,
      choice == MosaicChoice::kKeep
          ? "it is kept, as --mosaic says"
          : "each pixel is taken for the mean around it (--mosaic keep leaves them)");
}

MosaicFilter::MosaicFilter(int width_px)
    : above_(static_cast<std::size_t>(width_px)),
      here_(static_cast<std::size_t>(width_px)),
      below_(static_cast<std::size_t>(width_px)) {}

template <typename Sample>
void MosaicFilter::level_rows(DecodedImage* image) {
  const int width = image->header.width_px;
  const int height = image->header.height_px;
  const std::size_t row_bytes = static_cast<std::size_t>(width) * sizeof(Sample);
  const auto row = [&](int v) { return &image->pixels[static_cast<std::size_t>(v) * row_bytes]; };
  sum_along<Sample>(row(1), width, &above_);  // mirrored at the first row
  sum_along<Sample>(row(0), width, &here_);
  for (int v = 0; v < height; ++v) {
    if (v + 1 < height) {
      sum_along<Sample>(row(v + 1), width, &below_);
    }
    // The row before the last one is overwritten by now, its sums are not.
    const std::vector<std::uint32_t>& next = v + 1 < height ? below_ : above_;
    for (std::size_t u = 0; u < here_.size(); ++u) {
      const auto level = static_cast<Sample>((above_[u] + 2 * here_[u] + next[u] + 8) / 16);
      std::memcpy(row(v) + u * sizeof level, &level, sizeof level);
    }
    above_.swap(here_);
    here_.swap(below_);
  }
}

void MosaicFilter::level(DecodedImage* image) {
  if (image->header.width_px < 2 || image->header.height_px < 2) {
    return;
  }
  if (image->header.format == PixelFormat::kGray16) {
    level_rows<std::uint16_t>(image);
  } else {
    level_rows<std::uint8_t>(image);
  }
}

}  // namespace polhode::platform
