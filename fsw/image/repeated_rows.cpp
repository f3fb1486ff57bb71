#include <cstring>

#include "base/assert.hpp"
#include "image/quality.hpp"

namespace polhode {
namespace {

/// Has the row something by which it could be recognised? 32 pixels that differ from its first
/// come again by chance, with noise of a level or more, less than once in 10^10.
bool telling(const std::uint8_t* row, int columns) {
  constexpr int kPixelsMin = 32;
  int different = 0;
  for (int column = 1; column < columns && different < kPixelsMin; ++column) {
    different += row[column] != row[0] ? 1 : 0;
  }
  return different >= kPixelsMin;
}

}  // namespace

RepeatedRows compare_rows(const cv::Mat& gray, const cv::Mat& previous) {
  RepeatedRows rows;
  if (previous.empty()) {
    return rows;
  }
  POLHODE_ASSERT(previous.size() == gray.size(), previous.total());
  int last = -1;
  for (int row = 0; row < gray.rows; ++row) {
    const std::uint8_t* now = gray.ptr<std::uint8_t>(row);
    const bool same =
        std::memcmp(now, previous.ptr<std::uint8_t>(row), static_cast<std::size_t>(gray.cols)) == 0;
    if (same && !telling(now, gray.cols)) {
      continue;
    }
    rows.repeated += same ? 1 : 0;
    rows.fresh += same ? 0 : 1;
    rows.changes += last >= 0 && last != static_cast<int>(same) ? 1 : 0;
    last = static_cast<int>(same);
  }
  return rows;
}

}  // namespace polhode
