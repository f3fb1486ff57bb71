#include "mask/target_mask.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "mask/behind.hpp"
#include "mask/shrink.hpp"

namespace polhode {
namespace {

constexpr int kGroupCellsMin = 5;  // a star's blur disc, 3 px across, touches 2 x 2 cells at most
// Cells around the target that stay open, for dark parts beside lit ones. Chosen; larger lets stars
// in, smaller loses features at the silhouette.
constexpr int kGrowCells = 2;

/// Clears groups that are too small. Counting cells by label takes a quarter of the time of
/// OpenCV's statistics.
void drop_small_groups(cv::Mat* cells) {
  cv::Mat labels;
  std::vector<int> count_of(
      static_cast<std::size_t>(cv::connectedComponents(*cells, labels, 8, CV_32S)), 0);
  for (int row = 0; row < labels.rows; ++row) {
    const int* label = labels.ptr<int>(row);
    for (int column = 0; column < labels.cols; ++column) {
      ++count_of[static_cast<std::size_t>(label[column])];
    }
  }
  if (std::any_of(count_of.begin(), count_of.end(), [](int n) { return n < kGroupCellsMin; })) {
    for (int row = 0; row < labels.rows; ++row) {
      const int* label = labels.ptr<int>(row);
      auto* cell = cells->ptr<std::uint8_t>(row);
      for (int column = 0; column < labels.cols; ++column) {
        if (count_of[static_cast<std::size_t>(label[column])] < kGroupCellsMin) {
          cell[column] = 0;
        }
      }
    }
  }
}

}  // namespace

bool TargetMask::contains(double u_px, double v_px) const {
  const int column = static_cast<int>(u_px + 0.5) / kCell_px;
  const int row = static_cast<int>(v_px + 0.5) / kCell_px;
  return u_px >= -0.5 && v_px >= -0.5 && row < cells.rows && column < cells.cols &&
         cells.at<std::uint8_t>(row, column) != 0;
}

void find_target(const cv::Mat& gray, const MaskOptions& options, TargetMask* mask) {
  const cv::Size size((gray.cols + TargetMask::kCell_px - 1) / TargetMask::kCell_px,
                      (gray.rows + TargetMask::kCell_px - 1) / TargetMask::kCell_px);
  const cv::Rect whole(0, 0, gray.cols, gray.rows);
  if (!options.enabled) {
    mask->cells.create(size, CV_8UC1);
    mask->cells.setTo(255);
    mask->region_px = whole;
    mask->coverage = 1.0;
    return;
  }
  shrink(gray, size, TargetMask::kCell_px, &mask->levels);
  cv::threshold(mask->levels, mask->cells, options.dark_level * 255.0, 255.0, cv::THRESH_BINARY);
  if (!border_is_full(mask->cells)) {  // stars are seen before black space alone
    drop_small_groups(&mask->cells);
  }
  cv::dilate(mask->cells, mask->cells, cv::Mat(), cv::Point(-1, -1), kGrowCells);
  measure_cells(whole, mask);
}

void measure_cells(const cv::Rect& bounds_px, TargetMask* mask) {
  constexpr int kCell_px = TargetMask::kCell_px;
  const cv::Rect cells = cv::boundingRect(mask->cells);
  mask->region_px = bounds_px & cv::Rect(cells.tl() * kCell_px, cells.size() * kCell_px);
  mask->coverage =
      static_cast<double>(cv::countNonZero(mask->cells)) / static_cast<double>(mask->cells.total());
}

}  // namespace polhode
