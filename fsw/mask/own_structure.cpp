#include "mask/own_structure.hpp"

#include <opencv2/imgproc.hpp>

#include "mask/mask_state.hpp"

namespace polhode {
namespace {

// Margin of cells: that of find_target beyond lit cells. Fewer leave features on the silhouette,
// more lose the target's beside it.
constexpr int kOwnGrowCells = 2;
// Margin of working pixels: half of the window of optical flow, 9 px, and the pixel of rounding.
constexpr int kGrowWorking_px = 5;

/// Not 0 where any pixel of a square of `side_px` is not 0, then grown. A square that the image's
/// edge cuts counts only where the reduced image has it.
cv::Mat reduced(const cv::Mat& pixels, const cv::Size& size, int side_px, int grow) {
  cv::Mat small = cv::Mat::zeros(size, CV_8UC1);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const cv::Rect square(column * side_px, row * side_px, side_px, side_px);
      const cv::Mat part = pixels(square & cv::Rect({}, pixels.size()));
      small.at<std::uint8_t>(row, column) = cv::countNonZero(part) > 0 ? 255 : 0;
    }
  }
  cv::dilate(small, small, cv::Mat(), cv::Point(-1, -1), grow);
  return small;
}

}  // namespace

OwnStructure own_structure(const cv::Mat& pixels) {
  constexpr int kCell_px = TargetMask::kCell_px;
  const cv::Size cells((pixels.cols + kCell_px - 1) / kCell_px,
                       (pixels.rows + kCell_px - 1) / kCell_px);
  const int decimation = decimation_of(pixels.cols, pixels.rows);
  const cv::Size working(pixels.cols / decimation, pixels.rows / decimation);
  return {.pixels = pixels,
          .cells = reduced(pixels, cells, kCell_px, kOwnGrowCells),
          .working = reduced(pixels, working, decimation, kGrowWorking_px)};
}

void blacken(const OwnStructure& own, cv::Mat* gray) { gray->setTo(0, own.pixels); }

void close_cells(const OwnStructure& own, TargetMask* mask) {
  mask->cells.setTo(0, own.cells);
  measure_cells(mask->region_px, mask);
}

void leave_out(const OwnStructure& own, MaskState* state) {
  if (state->outline.size() == own.working.size()) {
    state->outline.setTo(0, own.working);
  }
  auto& tracks = state->points.tracks;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const cv::Point at(tracks[i].now());
    const bool inside = cv::Rect({}, own.working.size()).contains(at);
    if (!inside || own.working.at<std::uint8_t>(at) == 0) {
      tracks[kept++] = tracks[i];
    }
  }
  tracks.resize(kept);
}

}  // namespace polhode
