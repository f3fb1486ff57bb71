// Where the target is in the image: everything that is not empty space.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "mask/options.hpp"

namespace polhode {

/// At a quarter of the image's resolution: pixel (x, y) of the image is under cell (x / 4, y / 4).
struct TargetMask {
  // Chosen: a star's disc of 3 px stays under kGroupCellsMin cells. Larger loses thin parts,
  // smaller costs time.
  static constexpr int kCell_px = 4;

  cv::Mat levels;  ///< CV_8UC1, mean of the pixels over each cell; not where the mask is disabled
  cv::Mat cells;   ///< CV_8UC1, 255 on the target and 2 cells around it
  cv::Rect region_px;  ///< bounding box in pixels of the image; empty when nothing is bright enough
  double coverage = 0.0;  ///< fraction of the image

  [[nodiscard]] bool contains(double u_px, double v_px) const;
};

/// Cells brighter than the dark level, in connected groups of at least 5 cells (stars are smaller),
/// grown by 2 cells. Disabled, or without a dark background, the whole image is the target.
void find_target(const cv::Mat& gray, const MaskOptions& options, TargetMask* mask);

/// Sets `region_px`, within the bounds, and `coverage` from the cells.
void measure_cells(const cv::Rect& bounds_px, TargetMask* mask);

}  // namespace polhode
