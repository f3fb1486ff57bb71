#include "mask/foreground.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/avx2_dispatch.hpp"
#include "base/limited.hpp"
#include "mask/grown.hpp"
#include "mask/shrink.hpp"

namespace polhode {
namespace {

// Size of a cell of the grid of the target's motion. A multiple of every step of log-odds. Chosen:
// about the points' spacing on a target of 100 px; larger blurs the motion of faces.
constexpr int kCell_px = 8;
// Side of the window over which differences are summed. With 3, overlap rises by 0.01 and attitudes
// before the Earth get 6 % worse (decision 0006).
constexpr int kDifferenceWindow_px = 5;
// Bound on a pixel's disagreement, in sigmas. Chosen: one pixel at the limit counts 8 / 25 in its
// window, as much as kTargetLogOdds; larger lets single pixels decide.
constexpr double kCapSigma = 8;
// Bound in levels: the largest for which differences fit a byte, see below.
constexpr double kNoiseMost = 8;
// Offset of the differences, which are stored in bytes.
constexpr int kNoDifference = 128;
static_assert(kCapSigma * kNoiseMost < kNoDifference);

/// Level of an image between its pixels, bilinear. The place is inside.
double level_at(const cv::Mat& image, double u_px, double v_px) {
  const int column = static_cast<int>(u_px);
  const int row = static_cast<int>(v_px);
  const double right = u_px - column;
  const double down = v_px - row;
  const auto* above = image.ptr<std::uint8_t>(row) + column;
  const auto* below = image.ptr<std::uint8_t>(row + 1) + column;
  return (1.0 - down) * ((1.0 - right) * above[0] + right * above[1]) +
         down * ((1.0 - right) * below[0] + right * below[1]);
}

/// One sigma of a pixel's noise, in levels: from the median absolute difference of the newest image
/// and the same places in an earlier one.
double measure_noise(const cv::Mat& now,
                     const cv::Mat& before,
                     const cv::Matx33d& motion,
                     const cv::Rect& region) {
  constexpr int kSampleStep = 6;       // one pixel of 36: the median is of thousands still
  constexpr int kBlack = 8;            // black pixels have no noise: it is cut off at zero
  constexpr double kNoiseLeast = 1.0;  // medians are whole levels, and sums are divided by it
  const cv::Matx33d back = motion.inv();
  std::array<int, 256> counts{};
  int total = 0;
  for (int row = region.y + 1; row < region.br().y; row += kSampleStep) {
    const auto* levels = now.ptr<std::uint8_t>(row);
    for (int column = region.x + 1; column < region.br().x; column += kSampleStep) {
      if (levels[column] <= kBlack) {
        continue;
      }
      const cv::Vec3d from = back * cv::Vec3d(column, row, 1.0);
      const double u_px = from[0] / from[2];
      const double v_px = from[1] / from[2];
      if (u_px >= 0.0 && v_px >= 0.0 && u_px < before.cols - 1 && v_px < before.rows - 1) {
        ++counts[static_cast<std::size_t>(
            std::lround(std::abs(levels[column] - level_at(before, u_px, v_px))))];
        ++total;
      }
    }
  }
  int below = 0;
  std::size_t level = 0;
  while (level + 1 < counts.size() && 2 * (below += counts[level]) < total) {
    ++level;
  }
  // 1.4826: sigma of a normal distribution by its median absolute deviation. The difference has the
  // noise of two images.
  return std::clamp(static_cast<double>(level) * 1.4826 / std::sqrt(2.0), kNoiseLeast, kNoiseMost);
}

/// Interpolates the motion of the target's points over `age` images to the grid's cells between and
/// around them.
void spread_motion(const PointsState& points, std::size_t age, TargetFlow* s) {
  const cv::Size size = points.image(0).size();
  const cv::Size grid((size.width + kCell_px - 1) / kCell_px,
                      (size.height + kCell_px - 1) / kCell_px);
  s->flow.create(grid, CV_32FC2);
  s->weight.create(grid, CV_32FC1);
  s->flow.setTo(cv::Scalar::all(0.0));
  s->weight.setTo(0.0);
  for (const MaskTrack& track : points.tracks) {
    if (track.kind == TrackClass::kTarget && track.count > 1) {
      const cv::Point cell(static_cast<int>(track.now().x) / kCell_px,
                           static_cast<int>(track.now().y) / kCell_px);
      s->flow.at<cv::Point2f>(cell) += track.motion(age);
      s->weight.at<float>(cell) += 1.0F;
    }
  }
  // Sigmas of two Gaussians, in cells: 14 px, and three times that where no point is near. Chosen;
  // larger mixes the motions of faces.
  constexpr double kNear = 1.75;
  constexpr double kFar = 3.0 * kNear;
  // Weight of the wider one, which is nine times lower: a far point counts 0.01 of a near one.
  constexpr double kFarShare = 0.09;
  constexpr float kWeightMin = 1E-9F;  // so that nothing is divided by zero
  cv::GaussianBlur(s->flow, s->flow_far, cv::Size(0, 0), kFar);
  cv::GaussianBlur(s->weight, s->weight_far, cv::Size(0, 0), kFar);
  cv::GaussianBlur(s->flow, s->flow, cv::Size(0, 0), kNear);
  cv::GaussianBlur(s->weight, s->weight, cv::Size(0, 0), kNear);
  cv::scaleAdd(s->flow_far, kFarShare, s->flow, s->flow);
  cv::scaleAdd(s->weight_far, kFarShare, s->weight, s->weight);
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      s->flow.at<cv::Point2f>(row, column) /=
          std::max(s->weight.at<float>(row, column), kWeightMin);
    }
  }
}

/// The lowest and (in the high byte) the highest level of each pixel of an earlier image and its
/// four neighbours: origins are whole pixels, half a pixel off at most. With the diagonal
/// neighbours outlines in a room overlap by 0.01 less, and twice as many landmarks are on the
/// background (decision 0012).
void find_bounds(const cv::Mat& before, ForegroundScratch* s) {
  const cv::Mat around = cv::getStructuringElement(cv::MORPH_CROSS, cv::Size(3, 3));
  cv::erode(before, s->low, around);
  cv::dilate(before, s->high, around);
  s->bounds.create(before.size(), CV_16UC1);
  with_avx2([&] {
    const int columns = before.cols;
    for (int row = 0; row < before.rows; ++row) {
      const auto* low = s->low.ptr<std::uint8_t>(row);
      const auto* high = s->high.ptr<std::uint8_t>(row);
      auto* bounds = s->bounds.ptr<std::uint16_t>(row);
      for (int column = 0; column < columns; ++column) {
        bounds[column] = static_cast<std::uint16_t>(low[column] | high[column] << 8);
      }
    }
  });
}

/// Distance of each pixel of `now` from the range of levels within a pixel of its origin, in
/// levels.
void measure_excess(const cv::Mat& now, double cap, ForegroundScratch* s) {
  look_up(s->bounds, s->origins, &s->warped);
  s->excess.create(now.size(), CV_8UC1);
  with_avx2([&] {
    const int columns = now.cols;  // a copy: written bytes might alias the original
    const auto most = static_cast<std::int16_t>(cap);
    for (int row = 0; row < now.rows; ++row) {
      const auto* levels = now.ptr<std::uint8_t>(row);
      const auto* bounds = s->warped.ptr<std::uint16_t>(row);
      auto* excess = s->excess.ptr<std::uint8_t>(row);
      for (int column = 0; column < columns; ++column) {
        const auto level = static_cast<std::int16_t>(levels[column]);
        const auto low = static_cast<std::int16_t>(bounds[column] & 255);
        const auto high = static_cast<std::int16_t>(bounds[column] >> 8);
        const auto over = static_cast<std::int16_t>(level - high);
        const auto under = static_cast<std::int16_t>(low - level);
        const std::int16_t outside = over > under ? over : under;
        const std::int16_t positive = outside > 0 ? outside : std::int16_t{0};
        excess[column] = static_cast<std::uint8_t>(positive < most ? positive : most);
      }
    }
  });
}

/// Sets the pixels whose origin by the layer's motion lies inside the earlier image.
void find_visible(const cv::Matx33d& layer,
                  const cv::Size& size,
                  const cv::Rect& region,
                  cv::Mat* visible) {
  // Left out at the image border: half a window and the pixel of the bounds.
  constexpr float kBorder_px = 3.0F;
  const auto right = static_cast<float>(size.width) - 1.0F - kBorder_px;
  const auto bottom = static_cast<float>(size.height) - 1.0F - kBorder_px;
  const std::array<cv::Point2f, 4> before{cv::Point2f(kBorder_px, kBorder_px),
                                          cv::Point2f(right, kBorder_px),
                                          cv::Point2f(right, bottom),
                                          cv::Point2f(kBorder_px, bottom)};
  std::array<cv::Point2f, 4> now;
  cv::perspectiveTransform(before, now, layer);
  std::array<cv::Point, 4> corners_px;
  // Far outside, and small enough for the polygon's fixed-point corners.
  const float limit = 4.0F * static_cast<float>(size.width);
  for (std::size_t i = 0; i < now.size(); ++i) {
    corners_px[i] = cv::Point(static_cast<int>(std::clamp(now[i].x, -limit, limit)) - region.x,
                              static_cast<int>(std::clamp(now[i].y, -limit, limit)) - region.y);
  }
  visible->create(region.size(), CV_8UC1);
  visible->setTo(0);
  cv::fillConvexPoly(
      *visible, corners_px.data(), static_cast<int>(corners_px.size()), cv::Scalar(255));
}

/// Sets pixels that contradict all of the background's motions. Pixels with an origin outside of
/// the earlier image are unknown and contradict nothing.
void compare_with_background(const PointsState& points,
                             const BackgroundMotion& motion,
                             const cv::Rect& region,
                             ForegroundState* s) {
  const cv::Mat now = points.image(0)(region);
  for (std::size_t i = 0; i < motion.layers.size(); ++i) {
    trace_plane(motion.layers[i], region, points.whole().size(), &s->scratch.origins);
    if (i == 0) {
      // Mean of two images: one with an untypical median counts half.
      s->noise =
          0.5 * s->noise +
          0.5 * measure_noise(points.image(0), points.image(motion.age), motion.layers[i], region);
    }
    measure_excess(now, std::round(kCapSigma * s->noise), &s->scratch);
    find_visible(motion.layers[i], points.image(0).size(), region, &s->scratch.visible);
    cv::bitwise_and(s->scratch.excess, s->scratch.visible, s->scratch.excess);
    if (i == 0) {
      cv::swap(s->scratch.excess, s->scratch.least);
    } else {
      cv::min(s->scratch.excess, s->scratch.least, s->scratch.least);
    }
  }
}

void compare_with_target(const PointsState& points,
                         std::size_t age,
                         const cv::Rect& region,
                         ForegroundState* s) {
  spread_motion(points, age, &s->scratch.target);
  trace_flow(s->scratch.target.flow, kCell_px, region, points.whole().size(), &s->scratch.origins);
  measure_excess(points.image(0)(region), std::round(kCapSigma * s->noise), &s->scratch);
}

/// Excess of the disagreement with the background's motions over that with the target's, summed
/// over the window.
void sum_over_window(ForegroundScratch* s) {
  s->difference.create(s->least.size(), CV_8UC1);
  const int columns = s->least.cols;
  for (int row = 0; row < s->least.rows; ++row) {
    const auto* background = s->least.ptr<std::uint8_t>(row);
    const auto* target = s->excess.ptr<std::uint8_t>(row);
    auto* difference = s->difference.ptr<std::uint8_t>(row);
    for (int column = 0; column < columns; ++column) {
      difference[column] =
          static_cast<std::uint8_t>(kNoDifference + background[column] - target[column]);
    }
  }
  cv::boxFilter(s->difference,
                s->sum,
                CV_16U,
                cv::Size(kDifferenceWindow_px, kDifferenceWindow_px),
                cv::Point(-1, -1),
                false);
}

/// Moves positive log-odds along with the target and decays them. Adds this image's difference, in
/// sigmas a pixel.
/// @param compared_age  age of the motion on the grid
void carry_and_add(std::size_t compared_age, const cv::Rect& region, ForegroundState* s) {
  // Decay per image: 1 / (1 - 0.55) = 2.2 images' worth. With 0.8 panels are filled before the
  // Earth (overlap 0.85), and shadows stay in a room (0.86; decision 0006).
  constexpr float kMemory = 0.55F;
  // Bound on one image's contribution. Chosen: with it three images without support bring a full
  // sum of 4.4 to 0.7; larger makes single images decide.
  constexpr float kAddedMost = 2.0F;
  constexpr int kPixels = kDifferenceWindow_px * kDifferenceWindow_px;
  const auto scale = static_cast<float>(1.0 / (kPixels * s->noise));
  s->scratch.target.flow *= 1.0 / static_cast<double>(compared_age);
  carry(s->scratch.target.flow,
        {region, s->step, kCell_px},
        s->log_odds,
        &s->scratch.from,
        &s->scratch.carried);
  const cv::Rect part = coarser(region, s->step);
  s->log_odds.setTo(0.0);
  with_avx2([&] {
    const int step = s->step;
    for (int row = 0; row < part.height; ++row) {
      const auto* carried = s->scratch.carried.ptr<float>(row);
      const auto* sum = s->scratch.sum.ptr<std::uint16_t>(row * step);
      auto* total = s->log_odds.ptr<float>(part.y + row) + part.x;
      for (int column = 0; column < part.width; ++column) {
        const float added =
            scale * static_cast<float>(sum[column * step] - kPixels * kNoDifference);
        const float known = kMemory * limited(carried[column], 0.0F, ForegroundState::kLogOddsMax);
        total[column] = limited(known + limited(added, -kAddedMost, kAddedMost),
                                -ForegroundState::kLogOddsMax,
                                ForegroundState::kLogOddsMax);
      }
    }
  });
}

}  // namespace

void resize_log_odds(const cv::Size& image, int step, ForegroundState* s) {
  const cv::Size size = coarser(cv::Rect(cv::Point(), image), step).size();
  if (s->log_odds.size() == size && s->step == step) {
    return;
  }
  const bool same_image =
      !s->log_odds.empty() && coarser({cv::Point(), image}, s->step).size() == s->log_odds.size();
  cv::swap(s->log_odds, s->scratch.before);
  if (same_image) {
    cv::resize(s->scratch.before,
               s->log_odds,
               size,
               0.0,
               0.0,
               step > s->step ? cv::INTER_AREA : cv::INTER_NEAREST);
  } else {
    s->log_odds.create(size, CV_32FC1);
    s->log_odds.setTo(0.0);
  }
  s->step = step;
}

void update_log_odds(const PointsState& points,
                     const BackgroundState& background,
                     const cv::Rect& region,
                     ForegroundState* s) {
  // Decay for an image without a comparison: half is left after three. Chosen; smaller loses the
  // target when the background is not explained for a while.
  constexpr double kUnsupported = 0.8;
  // A corner of a cell of the motion's grid.
  const cv::Point start(region.x / kCell_px * kCell_px, region.y / kCell_px * kCell_px);
  s->region = cv::Rect(start, region.br()) & points.whole();
  const bool explained = std::any_of(background.motions.begin(),
                                     background.motions.end(),
                                     [](const BackgroundMotion& m) { return !m.layers.empty(); });
  if (!explained || background.target_tracks == 0) {
    s->log_odds *= kUnsupported;
    return;
  }
  // One age an image, by turns: outlines overlap as well (0.860 on four scenes) as with both ages
  // (0.859), with one comparison instead of two.
  const BackgroundMotion* motion = &background.motions[s->longer ? 1 : 0];
  if (motion->layers.empty()) {
    motion = &background.motions[s->longer ? 0 : 1];
  }
  s->longer = !s->longer;
  find_bounds(points.image(motion->age), &s->scratch);
  compare_with_background(points, *motion, s->region, s);
  compare_with_target(points, motion->age, s->region, s);
  sum_over_window(&s->scratch);
  carry_and_add(motion->age, s->region, s);
}

void remember_outline(const cv::Mat& outline, ForegroundState* s) {
  // After one image 0.55 of it is left, which is over kTargetLogOdds, and after two it is under.
  constexpr float kRemembered = 0.7F;
  cover_by_half(outline, s->log_odds.size(), &s->scratch.covered);
  with_avx2([&] {
    for (int row = 0; row < s->log_odds.rows; ++row) {
      const auto* target = s->scratch.covered.ptr<std::uint8_t>(row);
      auto* total = s->log_odds.ptr<float>(row);
      for (int column = 0; column < s->log_odds.cols; ++column) {
        const float least = target[column] != 0 ? kRemembered : -ForegroundState::kLogOddsMax;
        const float most = target[column] != 0 ? ForegroundState::kLogOddsMax : 0.0F;
        total[column] = limited(total[column], least, most);
      }
    }
  });
}

void clear(ForegroundState* s) {
  if (!s->log_odds.empty()) {
    s->log_odds.setTo(0.0);
  }
  s->noise = ForegroundState::kNoiseFirst;
  s->longer = true;
}

}  // namespace polhode
