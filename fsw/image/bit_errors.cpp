#include <algorithm>
#include <opencv2/core/hal/intrin.hpp>
#include <vector>

#include "base/assert.hpp"
#include "image/quality.hpp"

namespace polhode {
namespace {

// Levels by which a pixel is an outlier: only the flip of the highest bit reaches it. With 24
// levels clouds have 184 such pixels of 230 400, which hides one flipped bit in 0.2 % of the pixels
// (decision 0003).
constexpr int kStep = 80;

/// Counts outlier pixels of a row: over (or under) all eight neighbours by kStep and twice their
/// range. So edges, lines and grain do not count. Peaks of stars do, alike in each frame. With four
/// neighbours clouds had three times as many (decision 0002).
int impulses_in_row(const std::uint8_t* above,
                    const std::uint8_t* row,
                    const std::uint8_t* below,
                    int columns) {
  int count = 0;
  int column = 1;
  constexpr int kTimesMax = 255;  // so that a lane's sum fits a byte
  cv::v_uint8x16 counts = cv::v_setzero_u8();
  int times = 0;
  const cv::v_uint8x16 step = cv::v_setall_u8(kStep);
  const cv::v_uint8x16 one = cv::v_setall_u8(1);
  for (; column + 17 <= columns; column += 16) {
    const cv::v_uint8x16 p = cv::v_load(row + column);
    cv::v_uint8x16 high = cv::v_load(row + column - 1);
    cv::v_uint8x16 low = high;
    const auto include = [&](const std::uint8_t* neighbours) {
      const cv::v_uint8x16 n = cv::v_load(neighbours + column);
      high = cv::v_max(high, n);
      low = cv::v_min(low, n);
    };
    include(row + 1);
    for (const std::uint8_t* other : {above, below}) {
      include(other - 1);
      include(other);
      include(other + 1);
    }
    const cv::v_uint8x16 range = high - low;  // saturating, as all sums here
    const cv::v_uint8x16 limit = range + range + step;
    const cv::v_uint8x16 out = cv::v_max(p - high, low - p);
    counts = counts + cv::v_min(out - limit, one);
    if (++times == kTimesMax) {
      count += static_cast<int>(cv::v_reduce_sum(counts));
      counts = cv::v_setzero_u8();
      times = 0;
    }
  }
  count += static_cast<int>(cv::v_reduce_sum(counts));
  for (; column + 1 < columns; ++column) {
    const int p = row[column];
    const auto [low, high] = std::minmax({above[column - 1],
                                          above[column],
                                          above[column + 1],
                                          row[column - 1],
                                          row[column + 1],
                                          below[column - 1],
                                          below[column],
                                          below[column + 1]});
    const int limit = std::min(255, 2 * (high - low) + kStep);
    count += std::max(p - high, low - p) > limit ? 1 : 0;
  }
  return count;
}

/// Sum of absolute differences.
int difference(const std::uint8_t* a, const std::uint8_t* b, int columns) {
  unsigned sum = 0;
  int column = 0;
  for (; column + 16 <= columns; column += 16) {
    sum += cv::v_reduce_sad(cv::v_load(a + column), cv::v_load(b + column));
  }
  int rest = static_cast<int>(sum);
  for (; column < columns; ++column) {
    rest += std::abs(a[column] - b[column]);
  }
  return rest;
}

/// A broken line differs from the rows on its two sides, which agree.
bool broken_line(const cv::Mat& gray, int row) {
  // Mean over the row. A thin strut or the sensor's noise has 2, random bytes 64 or more. Chosen
  // between.
  constexpr double kLevelsMin = 8.0;
  // The rows above and below differ by less than a third of the line's difference. Chosen; larger
  // misses lines across texture.
  constexpr int kTimes = 3;
  const std::uint8_t* above = gray.ptr<std::uint8_t>(row - 1);
  const std::uint8_t* here = gray.ptr<std::uint8_t>(row);
  const std::uint8_t* below = gray.ptr<std::uint8_t>(row + 1);
  const int from_above = difference(above, here, gray.cols);
  if (from_above < kLevelsMin * gray.cols) {
    return false;
  }
  const int from_below = difference(here, below, gray.cols);
  return std::min(from_above, from_below) > std::max(static_cast<int>(kLevelsMin * gray.cols),
                                                     kTimes * difference(above, below, gray.cols));
}

constexpr int kSide_px = 16;  // a vector of bytes

/// Roughness: the smaller of the mean changes from pixel to pixel along and across rows.
int roughness(const cv::Mat& gray, int row0, int column0) {
  unsigned across = 0;
  unsigned along = 0;
  for (int row = row0; row < row0 + kSide_px; ++row) {
    const std::uint8_t* p = gray.ptr<std::uint8_t>(row) + column0;
    if (row > row0) {
      across +=
          cv::v_reduce_sad(cv::v_load(p), cv::v_load(gray.ptr<std::uint8_t>(row - 1) + column0));
    }
    const cv::v_uint8x16 here = cv::v_load(p);
    along += cv::v_reduce_sad(here, cv::v_rotate_left<1>(here, cv::v_setall_u8(p[0])));
  }
  return static_cast<int>(std::min(across, along) / (kSide_px * (kSide_px - 1)));
}

/// Counts tiles that are rough and much rougher than in the last good frame nearby. The finest
/// texture is nearly as rough, but does not appear from one frame to the next.
int count_rough_tiles(const cv::Mat& gray, QualityHistory* history) {
  // Under the roughness of bytes with one flipped bit in ten, 45. Random bytes have 85: a third
  // of their range, 256.
  constexpr int kRough = 40;
  // Chosen; larger misses errors in rough texture, smaller counts texture that comes into view.
  constexpr int kTimes = 2;
  history->roughness.create(gray.rows / kSide_px, gray.cols / kSide_px, CV_8UC1);
  const bool any_before = !history->roughness_good.empty();
  int count = 0;
  for (int row = 0; row < history->roughness.rows; ++row) {
    const std::uint8_t* before =
        any_before ? history->roughness_good.ptr<std::uint8_t>(row) : nullptr;
    std::uint8_t* now = history->roughness.ptr<std::uint8_t>(row);
    for (int column = 0; column < history->roughness.cols; ++column) {
      now[column] = static_cast<std::uint8_t>(roughness(gray, row * kSide_px, column * kSide_px));
      const int limit = any_before ? std::max(kRough, kTimes * before[column]) : kRough;
      count += now[column] > limit ? 1 : 0;
    }
  }
  return count;
}

/// A line that was broken in none of the last frames, good or bad: errors strike random rows, a
/// crosshair the same ones.
bool is_new_line(int row, bool broken, QualityHistory* history) {
  std::uint8_t& known = history->lines_known.at<std::uint8_t>(row);
  const bool is_new = broken && known == 0;
  known = broken ? static_cast<std::uint8_t>(QualityHistory::kFrames)
                 : static_cast<std::uint8_t>(std::max(0, known - 1));
  return is_new;
}

}  // namespace

BitErrorTraces find_bit_errors(const cv::Mat& gray, QualityHistory* history) {
  POLHODE_ASSERT(gray.type() == CV_8UC1, gray.type());
  if (history->lines_known.empty()) {
    history->lines_known = cv::Mat::zeros(gray.rows, 1, CV_8UC1);
  }
  BitErrorTraces traces;
  int impulses = 0;
  for (int row = 1; row + 1 < gray.rows; ++row) {
    impulses += impulses_in_row(gray.ptr<std::uint8_t>(row - 1),
                                gray.ptr<std::uint8_t>(row),
                                gray.ptr<std::uint8_t>(row + 1),
                                gray.cols);
    traces.lines += is_new_line(row, broken_line(gray, row), history) ? 1 : 0;
  }
  traces.rough_tiles = count_rough_tiles(gray, history);
  traces.pixels = static_cast<double>(gray.total());
  traces.impulse_fraction = static_cast<double>(impulses) / traces.pixels;
  return traces;
}

}  // namespace polhode
