#include "mask/appearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "base/wide.hpp"
#include "mask/grown.hpp"

namespace polhode {
namespace {

constexpr int kLevels = 16;
constexpr int kRoughnesses = 4;
constexpr std::size_t kLooks = kLevels * kRoughnesses;
using Shares = std::array<double, kLooks>;

// What a look e times as frequent on the target counts; an outline counts as much.
constexpr double kShare = 0.3;
// Looks that so few places have tell nothing, and none tells more than e^2.
constexpr double kRare = 0.003;
constexpr double kLogMost = 2.0;

/// Number of a look. Highest less lowest level of 3 x 3 pixels: even, noise or faint texture,
/// texture, an edge.
std::uint8_t look_of(std::uint8_t level, std::uint8_t range) {
  const int roughness = (range >= 8 ? 1 : 0) + (range >= 24 ? 1 : 0) + (range >= 64 ? 1 : 0);
  return static_cast<std::uint8_t>(roughness * kLevels + level / (256 / kLevels));
}

/// Number of each pixel's look.
void find_looks(const cv::Mat& picture, AppearanceScratch* s) {
  cv::Mat& range = s->one;
  cv::dilate(picture, range, cv::Mat());
  cv::erode(picture, s->other, cv::Mat());
  cv::subtract(range, s->other, range);
  s->looks.create(picture.size(), CV_8UC1);
  widely([&] {
    const int columns = picture.cols;  // what octets are written to could be this, too
    for (int row = 0; row < picture.rows; ++row) {
      const auto* level = picture.ptr<std::uint8_t>(row);
      const auto* rough = range.ptr<std::uint8_t>(row);
      auto* looks = s->looks.ptr<std::uint8_t>(row);
      for (int column = 0; column < columns; ++column) {
        looks[column] = look_of(level[column], rough[column]);
      }
    }
  });
}

/// Pixels of each look.
using Counts = std::array<std::uint32_t, kLooks>;

double sum_of(const Counts& counts) { return std::accumulate(counts.begin(), counts.end(), 0.0); }

Shares shares_of(const Counts& counts) {
  const double all = std::max(1.0, sum_of(counts));
  Shares shares{};
  std::transform(
      counts.begin(), counts.end(), shares.begin(), [&](std::uint32_t n) { return n / all; });
  return shares;
}

/// Looks outside, in neither, and inside, by every second row and column.
/// @param inside, not_outside  CV_8UC1, 0 and 255; what is inside is not outside.
std::array<Counts, 3> count_looks(const cv::Mat& looks,
                                  const cv::Mat& inside,
                                  const cv::Mat& not_outside) {
  std::array<Counts, 3> counts{};
  constexpr int kStep = 2;
  for (int row = 0; row < looks.rows; row += kStep) {
    const auto* look = looks.ptr<std::uint8_t>(row);
    const auto* in = inside.ptr<std::uint8_t>(row);
    const auto* not_out = not_outside.ptr<std::uint8_t>(row);
    for (int column = 0; column < looks.cols; column += kStep) {
      const auto side = static_cast<std::size_t>((in[column] & 1) + (not_out[column] & 1));
      counts[side][look[column]] += kStep * kStep;
    }
  }
  return counts;
}

/// What a place says whose look is so many times as frequent on the target as beside it.
float said_by(double ratio) {
  return static_cast<float>(kShare * std::clamp(std::log(ratio), -kLogMost, kLogMost));
}

/// The outline's box and a third of its width around. Empty without an outline.
cv::Rect box_of_looks(const cv::Mat& outline) {
  const cv::Rect box = cv::boundingRect(outline);
  if (box.empty()) {
    return box;
  }
  const int margin = std::max(8, std::max(box.width, box.height) / 3);
  return grown(box, margin) & cv::Rect(cv::Point(), outline.size());
}

}  // namespace

void add_appearance(const cv::Mat& picture,
                    const cv::Mat& outline,
                    const cv::Mat& matches,
                    const cv::Rect& region,
                    int step,
                    AppearanceScratch* s,
                    cv::Mat* opinion) {
  const cv::Rect box = box_of_looks(outline);
  if (box.empty()) {
    return;
  }
  find_looks(picture(box), s);
  // An outline is off by a few pixels: those are left out.
  cv::erode(outline(box), s->one, cv::Mat(), cv::Point(-1, -1), 2);
  cv::dilate(outline(box), s->other, cv::Mat(), cv::Point(-1, -1), 4);
  const auto [outside, neither, inside] = count_looks(s->looks, s->one, s->other);
  if (std::min(sum_of(inside), sum_of(outside)) * kRare < 1.0) {
    return;  // one pixel would be a look of its own
  }
  const Shares target = shares_of(inside);
  const Shares around = shares_of(outside);
  std::array<float, kLooks> says{};
  std::array<float, kLooks> says_of_known{};
  for (std::size_t k = 0; k < kLooks; ++k) {
    says[k] = said_by((target[k] + kRare) / (around[k] + kRare));
    says_of_known[k] = said_by(target[k]);
  }
  const cv::Rect heard = box & region;
  for (int row = heard.y; row < heard.br().y; row += step) {
    const auto* look = s->looks.ptr<std::uint8_t>(row - box.y);
    const auto* is_known = matches.ptr<std::uint8_t>(row);
    auto* to = opinion->ptr<float>(row / step) + heard.x / step;
    for (int column = heard.x; column < heard.br().x; column += step) {
      const std::uint8_t of = look[column - box.x];
      *to++ += is_known[column] != 0 ? says_of_known[of] : says[of];
    }
  }
}

}  // namespace polhode
