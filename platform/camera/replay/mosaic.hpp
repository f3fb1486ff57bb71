// A colour sensor's mosaic (Bayer) that stands in one channel as it came.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "camera/replay/decode.hpp"

namespace polhode::platform {

/// Recorded gray sequences stay below 0.004, a Bayer sensor before a gray body has 0.2 to 0.8.
constexpr double kMosaicContrastMin = 0.04;

/// Handling of a mosaic: by the images, or as the user chooses.
enum class MosaicChoice { kFind, kLevel, kKeep };

/// Of the four places in a cell of 2x2 pixels: by which share of the level they are brighter than
/// the mean around them.
using MosaicCells = std::array<double, 4>;

double contrast_of(const MosaicCells& cells);

/// Nothing where the places do not differ, or not alike all over the image.
std::optional<MosaicCells> mosaic_of(const DecodedImage& image);

/// A remark on a mosaic and its handling.
std::string mosaic_remark(double contrast, MosaicChoice choice);

/// Takes a mosaic out of images of one width; its rows are acquired once.
class MosaicFilter {
 public:
  explicit MosaicFilter(int width_px);

  /// Replaces each pixel by the mean around it, 1-2-1 along rows and columns: whatever the pattern
  /// of 2x2 pixels, its mean is left. Nothing moves.
  void level(DecodedImage* image);

 private:
  template <typename Sample>
  void level_rows(DecodedImage* image);

  std::vector<std::uint32_t> above_;  ///< rows of sums along the row, four times the level
  std::vector<std::uint32_t> here_;
  std::vector<std::uint32_t> below_;
};

}  // namespace polhode::platform
