#include <cstdlib>
#include <cstring>

#include "base/assert.hpp"
#include "image/quality.hpp"

namespace polhode {
namespace {

/// Can the row be recognised? Blank rows cannot.
bool recognisable(const std::uint8_t* row, int columns) {
  // Least pixels that differ from the first: such a row is repeated by chance less than once in
  // 10^10, with noise of a level or more.
  constexpr int kPixelsMin = 32;
  int different = 0;
  for (int column = 1; column < columns && different < kPixelsMin; ++column) {
    different += row[column] != row[0] ? 1 : 0;
  }
  return different >= kPixelsMin;
}

/// Mean level of a row.
int mean_level(const std::uint8_t* row, int columns) {
  constexpr int kRowStep = 16;  // 40 pixels in a row of 640: enough for a blank row
  int sum = 0;
  int count = 0;
  for (int column = 0; column < columns; column += kRowStep) {
    sum += row[column];
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

/// Counts repeated, fresh and blank rows in the order of the image.
struct Runs {
  RepeatedRows rows;
  int last = -1;

  void add(bool same) {
    rows.repeated += same ? 1 : 0;
    rows.fresh += same ? 0 : 1;
    rows.changes += last >= 0 && last != static_cast<int>(same) ? 1 : 0;
    last = static_cast<int>(same);
  }
};

}  // namespace

RepeatedRows compare_rows(const cv::Mat& gray,
                          const ImageOptions& options,
                          const QualityHistory& history) {
  const cv::Mat& previous = history.previous;
  if (previous.empty()) {
    return {};
  }
  POLHODE_ASSERT(previous.size() == gray.size(), previous.total());
  const int apart = static_cast<int>(options.dark_level * 255.0);
  Runs recognisable_rows;
  Runs with_blank;
  int blank = 0;
  for (int row = 0; row < gray.rows; ++row) {
    const std::uint8_t* now = gray.ptr<std::uint8_t>(row);
    const bool same =
        std::memcmp(now, previous.ptr<std::uint8_t>(row), static_cast<std::size_t>(gray.cols)) == 0;
    if (!same || recognisable(now, gray.cols)) {
      recognisable_rows.add(same);
      with_blank.add(same);
    } else if (!history.row_levels_good.empty() &&
               std::abs(mean_level(now, gray.cols) -
                        history.row_levels_good.at<std::uint8_t>(row)) > apart) {
      ++blank;
      with_blank.add(true);
    }
  }
  // An eighth of the image (decision 0002): a body's edge moves over fewer rows between frames. A
  // frame that is blank all over need not be a repeated one.
  constexpr int kBlankPart = 8;
  const bool torn_off = kBlankPart * blank >= gray.rows && with_blank.rows.fresh > 0;
  return torn_off ? with_blank.rows : recognisable_rows.rows;
}

void remember_rows(const cv::Mat& gray, QualityHistory* history) {
  history->row_levels_good.create(gray.rows, 1, CV_8UC1);
  for (int row = 0; row < gray.rows; ++row) {
    history->row_levels_good.at<std::uint8_t>(row) =
        static_cast<std::uint8_t>(mean_level(gray.ptr<std::uint8_t>(row), gray.cols));
  }
}

}  // namespace polhode
