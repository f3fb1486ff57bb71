#include "mask/appearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "base/avx2_dispatch.hpp"
#include "mask/grown.hpp"
#include "mask/outline.hpp"

namespace polhode {
namespace {

// Gray levels and roughnesses of an appearance (decision 0008). Chosen; with more of them each has
// fewer pixels, too few on a small target.
constexpr int kLevels = 16;
constexpr int kRoughnesses = 4;
constexpr std::size_t kAppearances = kLevels * kRoughnesses;
using Shares = std::array<double, kAppearances>;

// Unary cost of an appearance that is e times as frequent on the target: that of the outline. With
// 0.15 and 0.2 overlap is up to 0.01 lower before the Earth (decision 0008).
constexpr double kCostShare = 0.3;
// Least share of pixels of an appearance that counts: a fifth of an even distribution over the 64.
// Chosen; smaller lets single pixels decide.
constexpr double kRare = 0.003;
// Bound on the logarithm: e^2, a cost of 0.6 in all. Chosen: larger outweighs outline and motion.
constexpr double kLogMost = 2.0;

/// Number of an appearance. Roughness is the range of 3 x 3 pixels.
std::uint8_t appearance_of(std::uint8_t level, std::uint8_t range) {
  // Bounds of the roughnesses, in levels: even, noise or faint texture, texture, edge. Chosen, in
  // steps of about 3: noise of 2 levels has a range of 6 over nine pixels.
  constexpr int kFaint = 8;
  constexpr int kTexture = 24;
  constexpr int kEdge = 64;
  const int roughness =
      (range >= kFaint ? 1 : 0) + (range >= kTexture ? 1 : 0) + (range >= kEdge ? 1 : 0);
  return static_cast<std::uint8_t>(roughness * kLevels + level / (256 / kLevels));
}

/// Number of each pixel's appearance.
void find_appearances(const cv::Mat& image, AppearanceScratch* s) {
  cv::Mat& range = s->one;
  cv::dilate(image, range, cv::Mat());
  cv::erode(image, s->other, cv::Mat());
  cv::subtract(range, s->other, range);
  s->appearances.create(image.size(), CV_8UC1);
  with_avx2([&] {
    const int columns = image.cols;  // a copy: written bytes might alias the original
    for (int row = 0; row < image.rows; ++row) {
      const auto* level = image.ptr<std::uint8_t>(row);
      const auto* rough = range.ptr<std::uint8_t>(row);
      auto* appearances = s->appearances.ptr<std::uint8_t>(row);
      for (int column = 0; column < columns; ++column) {
        appearances[column] = appearance_of(level[column], rough[column]);
      }
    }
  });
}

/// Pixels of each appearance.
using Counts = std::array<std::uint32_t, kAppearances>;

double sum_of(const Counts& counts) { return std::accumulate(counts.begin(), counts.end(), 0.0); }

Shares shares_of(const Counts& counts) {
  const double all = std::max(1.0, sum_of(counts));
  Shares shares{};
  std::transform(
      counts.begin(), counts.end(), shares.begin(), [&](std::uint32_t n) { return n / all; });
  return shares;
}

/// Counts the appearances of pixels outside of the target, in the band between, and inside.
/// @param inside, not_outside  CV_8UC1, 0 and 255; `not_outside` is the inside and the band.
std::array<Counts, 3> count_appearances(const cv::Mat& appearances,
                                        const cv::Mat& inside,
                                        const cv::Mat& not_outside) {
  std::array<Counts, 3> counts{};
  constexpr int kStep = 2;  // every second row and column: a quarter of the time
  for (int row = 0; row < appearances.rows; row += kStep) {
    const auto* appearance = appearances.ptr<std::uint8_t>(row);
    const auto* in = inside.ptr<std::uint8_t>(row);
    const auto* not_out = not_outside.ptr<std::uint8_t>(row);
    for (int column = 0; column < appearances.cols; column += kStep) {
      const auto part = static_cast<std::size_t>((in[column] & 1) + (not_out[column] & 1));
      counts[part][appearance[column]] += kStep * kStep;
    }
  }
  return counts;
}

/// Unary cost of an appearance. @param ratio  its frequency on the target over that beside it.
float cost_of_ratio(double ratio) {
  return static_cast<float>(kCostShare * std::clamp(std::log(ratio), -kLogMost, kLogMost));
}

/// The outline's box and a third of its width around, at least kMarginMin_px. Empty without an
/// outline.
cv::Rect box_of_appearances(const cv::Mat& outline) {
  // A third leaves 1.8 times the box's pixels around it. Chosen; larger compares with places far
  // from the target.
  constexpr int kMarginMin_px = 8;
  const cv::Rect box = cv::boundingRect(outline);
  if (box.empty()) {
    return box;
  }
  const int margin = std::max(kMarginMin_px, std::max(box.width, box.height) / 3);
  return grown(box, margin) & cv::Rect(cv::Point(), outline.size());
}

}  // namespace

void add_appearance(const AppearanceInput& input, AppearanceScratch* s, cv::Mat* unary_cost) {
  const auto& [image, outline, matches, region, step] = input;
  const cv::Rect box = box_of_appearances(outline);
  if (box.empty()) {
    return;
  }
  find_appearances(image(box), s);
  // Band left out around the outline: its error outside, half of that inside, where a small target
  // would have nothing left.
  constexpr int kMarginOut_px = kOutlineOff_px;
  constexpr int kMarginIn_px = kOutlineOff_px / 2;
  cv::erode(outline(box), s->one, cv::Mat(), cv::Point(-1, -1), kMarginIn_px);
  cv::dilate(outline(box), s->other, cv::Mat(), cv::Point(-1, -1), kMarginOut_px);
  const auto [outside, neither, inside] = count_appearances(s->appearances, s->one, s->other);
  if (std::min(sum_of(inside), sum_of(outside)) * kRare < 1.0) {
    return;  // a single pixel would count
  }
  const Shares target = shares_of(inside);
  const Shares around = shares_of(outside);
  std::array<float, kAppearances> cost{};
  std::array<float, kAppearances> cost_of_known{};
  for (std::size_t k = 0; k < kAppearances; ++k) {
    cost[k] = cost_of_ratio((target[k] + kRare) / (around[k] + kRare));
    cost_of_known[k] = cost_of_ratio(target[k]);
  }
  const cv::Rect part = box & region;
  for (int row = part.y; row < part.br().y; row += step) {
    const auto* appearance = s->appearances.ptr<std::uint8_t>(row - box.y);
    const auto* is_known = matches.ptr<std::uint8_t>(row);
    auto* to = unary_cost->ptr<float>(row / step) + part.x / step;
    for (int column = part.x; column < part.br().x; column += step) {
      const std::uint8_t of = appearance[column - box.x];
      *to++ += is_known[column] != 0 ? cost_of_known[of] : cost[of];
    }
  }
}

}  // namespace polhode
