#include "mask/behind.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace polhode {
namespace {

// Two fifths of the picture's rim: the Earth behind half of the picture lights half of it. Before
// photographs of a body on a stand, which reaches the rim (up to 0.36), there is no motion to be
// told apart and much of the body to be lost.
constexpr double kRimLitMin = 0.4;
// The Earth behind a fifth of the picture or less lights a corner of it, which bodies and stands
// hardly reach.
constexpr double kCornerLitMin = 0.15;
// A limb that comes and goes about that is behind the target all the time.
constexpr double kRimLitLeft = 0.05;

/// Part of the outermost pixels that `counts` is true for.
template <typename Counts>
double part_of_rim(const cv::Size& size, const Counts& counts) {
  int found = 0;
  for (int column = 0; column < size.width; ++column) {
    found += (counts(column, 0) ? 1 : 0) + (counts(column, size.height - 1) ? 1 : 0);
  }
  for (int row = 1; row + 1 < size.height; ++row) {
    found += (counts(0, row) ? 1 : 0) + (counts(size.width - 1, row) ? 1 : 0);
  }
  return static_cast<double>(found) / (2.0 * (size.width + size.height) - 4.0);
}

double lit_part_of_rim(const cv::Mat& cells) {
  return part_of_rim(cells.size(),
                     [&](int column, int row) { return cells.at<std::uint8_t>(row, column) != 0; });
}

/// Is what is lit in a corner of the picture something else than the target? What the target stands
/// on is one piece with it.
bool is_apart(const cv::Mat& stats, int corner_label) {
  constexpr double kTargetMin = 0.02;  // of what is lit
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

bool rim_is_lit(const cv::Mat& cells) { return lit_part_of_rim(cells) > kRimLitLeft; }

bool rim_is_full(const cv::Mat& cells) { return lit_part_of_rim(cells) > kRimLitMin; }

bool is_behind(const cv::Mat& cells, const cv::Rect& body, bool was_behind, OutlineScratch* s) {
  const auto lit = [&](int column, int row) {
    return cells.at<std::uint8_t>(row, column) != 0 && !body.contains({column, row});
  };
  const double all = part_of_rim(cells.size(), lit);
  if (was_behind || all > kRimLitMin) {
    return all > kRimLitLeft;
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
    const double same = part_of_rim(cells.size(), [&](int column, int row) {
      return lit(column, row) && s->labels.at<int>(row, column) == label;
    });
    if (same > kCornerLitMin && is_apart(s->stats, label)) {
      return true;
    }
  }
  return false;
}

}  // namespace polhode
