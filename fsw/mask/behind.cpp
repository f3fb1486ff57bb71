#include "mask/behind.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace polhode {
namespace {

// Least lit part of the image border. The Earth behind half of the image lights half of it.
// Photographs of a body on a stand light up to 0.36: separating motions there would lose much of
// the body.
constexpr double kBorderLitMin = 0.4;
// Least lit part of a corner. The Earth behind a fifth of the image or less lights a corner, which
// bodies and stands hardly reach. Chosen; larger misses the Earth's edge, smaller takes a stand for
// a background.
constexpr double kCornerLitMin = 0.15;
// Least lit part of the border when something was behind the target in the last image: a limb may
// come and go.
constexpr double kBorderLitLeft = 0.05;

/// Part of the outermost pixels for which `counts` is true.
template <typename Counts>
double part_of_border(const cv::Size& size, const Counts& counts) {
  int found = 0;
  for (int column = 0; column < size.width; ++column) {
    found += (counts(column, 0) ? 1 : 0) + (counts(column, size.height - 1) ? 1 : 0);
  }
  for (int row = 1; row + 1 < size.height; ++row) {
    found += (counts(0, row) ? 1 : 0) + (counts(size.width - 1, row) ? 1 : 0);
  }
  return static_cast<double>(found) / (2.0 * (size.width + size.height) - 4.0);
}

double lit_part_of_border(const cv::Mat& cells) {
  return part_of_border(
      cells.size(), [&](int column, int row) { return cells.at<std::uint8_t>(row, column) != 0; });
}

/// Is the lit piece in a corner another one than the target? A stand is one piece with the target.
bool is_apart(const cv::Mat& stats, int corner_label) {
  // Least part of the lit pixels that a target beside the piece has. Chosen; larger misses small
  // targets beside the Earth, smaller takes specks for one.
  constexpr double kTargetMin = 0.02;
  int all = 0;
  int largest = 0;
  for (int label = 1; label < stats.rows; ++label) {
    const int area = stats.at<int>(label, cv::CC_STAT_AREA);
    all += area;
    largest = label == corner_label ? largest : std::max(largest, area);
  }
  return corner_label != 0 && largest > kTargetMin * all;
}

}  // namespace

bool border_is_lit(const cv::Mat& cells) { return lit_part_of_border(cells) > kBorderLitLeft; }

bool border_is_full(const cv::Mat& cells) { return lit_part_of_border(cells) > kBorderLitMin; }

bool is_behind(const cv::Mat& cells, const cv::Rect& body, bool was_behind, OutlineScratch* s) {
  const auto lit = [&](int column, int row) {
    return cells.at<std::uint8_t>(row, column) != 0 && !body.contains({column, row});
  };
  const double all = part_of_border(cells.size(), lit);
  if (was_behind || all > kBorderLitMin) {
    return all > kBorderLitLeft;
  }
  if (all <= kCornerLitMin) {
    return false;
  }
  cv::connectedComponentsWithStats(cells, s->labels, s->stats, s->centroids, 8, CV_32S);
  for (const cv::Point corner : {cv::Point(0, 0),
                                 cv::Point(cells.cols - 1, 0),
                                 cv::Point(0, cells.rows - 1),
                                 cv::Point(cells.cols - 1, cells.rows - 1)}) {
    const int label = s->labels.at<int>(corner);
    const double same = part_of_border(cells.size(), [&](int column, int row) {
      return lit(column, row) && s->labels.at<int>(row, column) == label;
    });
    if (same > kCornerLitMin && is_apart(s->stats, label)) {
      return true;
    }
  }
  return false;
}

}  // namespace polhode
