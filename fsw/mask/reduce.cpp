#include "mask/reduce.hpp"

#include <array>
#include <cstdint>
#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/imgproc.hpp>

#include "base/assert.hpp"

namespace polhode {
namespace {

constexpr int kWidthMax_px = 8192;
constexpr int kFactorMax = 16;  // 16 rows of 255 are 12 bits, 16 sums of those are 16

using ColumnSums = std::array<std::uint16_t, kWidthMax_px>;

using Rows = std::array<const std::uint8_t*, kFactorMax>;

/// Column by column over `factor` rows. With the factor known when this is compiled (not 0) the
/// inner loops are unrolled.
template <int kFactor>
void sum_columns(const Rows& rows, int factor, int width, ColumnSums* sums) {
  constexpr int kLanes = cv::v_uint8x16::nlanes;
  const auto count = static_cast<std::size_t>(kFactor > 0 ? kFactor : factor);
  int column = 0;
  for (; column + kLanes <= width; column += kLanes) {
    cv::v_uint16x8 low;
    cv::v_uint16x8 high;
    cv::v_expand(cv::v_load(rows[0] + column), low, high);
    for (std::size_t row = 1; row < count; ++row) {
      cv::v_uint16x8 first;
      cv::v_uint16x8 second;
      cv::v_expand(cv::v_load(rows[row] + column), first, second);
      low += first;
      high += second;
    }
    cv::v_store(sums->data() + column, low);
    cv::v_store(sums->data() + column + kLanes / 2, high);
  }
  for (; column < width; ++column) {
    unsigned sum = 0;
    for (std::size_t row = 0; row < count; ++row) {
      sum += rows[row][column];
    }
    (*sums)[static_cast<std::size_t>(column)] = static_cast<std::uint16_t>(sum);
  }
}

std::uint8_t rounded(unsigned sum, unsigned count) {
  const unsigned whole = sum / count;
  const unsigned twice = 2 * (sum % count);
  const bool up = twice > count || (twice == count && whole % 2 == 1);
  return static_cast<std::uint8_t>(whole + (up ? 1 : 0));
}

/// Sums of `factor` columns each, as means.
template <int kFactor>
void mean_columns(const ColumnSums& sums, int factor, int width, std::uint8_t* out) {
  const int step = kFactor > 0 ? kFactor : factor;
  const auto count = static_cast<unsigned>(step * step);
  const std::uint16_t* from = sums.data();
  for (int column = 0; column < width; ++column, from += step) {
    unsigned sum = 0;
    for (int k = 0; k < step; ++k) {
      sum += from[k];
    }
    out[column] = rounded(sum, count);
  }
}

template <int kFactor>
void reduce(const cv::Mat& gray, int factor, cv::Mat* small) {
  ColumnSums sums;
  Rows rows{};
  for (int row = 0; row < small->rows; ++row) {
    for (int k = 0; k < factor; ++k) {
      rows[static_cast<std::size_t>(k)] = gray.ptr<std::uint8_t>(row * factor + k);
    }
    sum_columns<kFactor>(rows, factor, small->cols * factor, &sums);
    mean_columns<kFactor>(sums, factor, small->cols, small->ptr<std::uint8_t>(row));
  }
}

}  // namespace

void reduce_by(const cv::Mat& gray, int factor, cv::Mat* small) {
  POLHODE_ASSERT(factor >= 1 && factor <= kFactorMax && gray.cols <= kWidthMax_px, factor);
  const cv::Size size(gray.cols / factor, gray.rows / factor);
  small->create(size, CV_8UC1);
  switch (factor) {
    case 1:
    case 2:
      cv::resize(gray(cv::Rect(0, 0, size.width * factor, size.height * factor)),
                 *small,
                 size,
                 0.0,
                 0.0,
                 cv::INTER_AREA);
      break;
    case 3:
      reduce<3>(gray, factor, small);
      break;
    case 4:
      reduce<4>(gray, factor, small);
      break;
    default:
      reduce<0>(gray, factor, small);
      break;
  }
}

}  // namespace polhode
