#include "mask/background.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "base/assert.hpp"

namespace polhode {
namespace {

constexpr int kWidthMax = 320;
constexpr int kWindow_px = 9;
constexpr int kLevels = 2;
// A homography through points that are followed to 0.2 px; three times that and a share for what is
// not quite plane.
constexpr double kFit_px = 1.0;
constexpr std::size_t kLayerTracksMin = 10;

const cv::Mat& picture(const BackgroundState& s, std::size_t age) {
  return s.pictures[(s.newest + BackgroundState::kPictures - age) % BackgroundState::kPictures];
}

const std::vector<cv::Point2f>& corners(const BackgroundState& s, std::size_t age) {
  return s.corners[(s.newest + BackgroundState::kPictures - age) % BackgroundState::kPictures];
}

/// The best corner of each tile of a grid.
void find_corners(const cv::Mat& gray, cv::Mat* score, std::vector<cv::Point2f>* out) {
  constexpr int kColumns = 16;
  constexpr int kRows = 10;
  static_assert(kColumns * kRows == BackgroundState::kTracks);
  constexpr float kScoreMin =
      5e-4F;  // of a step of 20 levels at a corner; noise of 2 levels gives a tenth
  out->clear();
  cv::cornerMinEigenVal(gray, *score, 3, 3);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const cv::Rect tile(cv::Point(c * gray.cols / kColumns, r * gray.rows / kRows),
                          cv::Point((c + 1) * gray.cols / kColumns, (r + 1) * gray.rows / kRows));
      double best = 0.0;
      cv::Point where;
      cv::minMaxLoc((*score)(tile), nullptr, &best, nullptr, &where);
      if (best > static_cast<double>(kScoreMin)) {
        out->push_back(cv::Point2f(where + tile.tl()));
      }
    }
  }
}

/// Does a group of points surround the middle, as a background does? The picture in 4 x 4 blocks:
/// at least three of the 12 outer ones hold some, and they hold at least half.
bool surrounds(const std::vector<cv::Point2f>& points, const cv::Size& size) {
  int outer = 0;
  std::array<bool, 16> block{};
  for (const cv::Point2f& p : points) {
    const int column =
        std::clamp(static_cast<int>(4.0F * p.x / static_cast<float>(size.width)), 0, 3);
    const int row =
        std::clamp(static_cast<int>(4.0F * p.y / static_cast<float>(size.height)), 0, 3);
    if (column == 0 || column == 3 || row == 0 || row == 3) {
      ++outer;
      block[static_cast<std::size_t>(4 * row + column)] = true;
    }
  }
  return std::count(block.begin(), block.end(), true) >= 3 &&
         2 * outer >= static_cast<int>(points.size());
}

/// Follows the reference's corners; what is known to be target is marked as such.
void follow(const cv::Mat& target, BackgroundState* s) {
  s->tracks.clear();
  const std::vector<cv::Point2f>& from = corners(*s, s->age);
  if (from.empty()) {
    return;
  }
  std::vector<cv::Point2f> to;
  std::vector<std::uint8_t> found;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(
      picture(*s, s->age),
      picture(*s, 0),
      from,
      to,
      found,
      error,
      cv::Size(kWindow_px, kWindow_px),
      kLevels,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, 0.02));
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (found[i] == 0) {
      continue;
    }
    MaskTrack track{.from = from[i], .to = to[i]};
    const cv::Point at(from[i]);
    if (!target.empty() && target.at<std::uint8_t>(at) != 0) {
      track.kind = TrackClass::kTarget;
    }
    (void)s->tracks.push_back(track);
  }
}

/// One plane motion after the other, each through the tracks that the ones before left over.
void fit_layers(BackgroundState* s) {
  s->layers.clear();
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;
  std::vector<std::size_t> index;
  while (!s->layers.full()) {
    from.clear();
    to.clear();
    index.clear();
    for (std::size_t i = 0; i < s->tracks.size(); ++i) {
      if (s->tracks[i].kind == TrackClass::kUnassigned) {
        from.push_back(s->tracks[i].from);
        to.push_back(s->tracks[i].to);
        index.push_back(i);
      }
    }
    if (from.size() < kLayerTracksMin) {
      return;
    }
    cv::Mat inlier;
    constexpr int kDrawsMax = 300;
    const cv::Mat H = cv::findHomography(from, to, cv::RANSAC, kFit_px, inlier, kDrawsMax, 0.99);
    if (H.empty()) {
      return;
    }
    std::vector<cv::Point2f> group;
    for (std::size_t i = 0; i < index.size(); ++i) {
      if (inlier.at<std::uint8_t>(static_cast<int>(i)) != 0) {
        group.push_back(to[i]);
      }
    }
    if (group.size() < kLayerTracksMin || !surrounds(group, picture(*s, 0).size())) {
      return;
    }
    for (std::size_t i = 0; i < index.size(); ++i) {
      if (inlier.at<std::uint8_t>(static_cast<int>(i)) != 0) {
        s->tracks[index[i]].kind = TrackClass::kBackground;
      }
    }
    (void)s->layers.push_back(cv::Matx33d(H));
  }
}

/// Where the layer's motion brings something from inside the earlier picture.
void find_seen(const cv::Matx33d& layer, BackgroundState* s) {
  constexpr float kRim_px = 2.0F;
  const cv::Size size = picture(*s, 0).size();
  const auto right = static_cast<float>(size.width) - 1.0F - kRim_px;
  const auto bottom = static_cast<float>(size.height) - 1.0F - kRim_px;
  const std::vector<cv::Point2f> before{
      {kRim_px, kRim_px}, {right, kRim_px}, {right, bottom}, {kRim_px, bottom}};
  std::vector<cv::Point2f> now;
  cv::perspectiveTransform(before, now, layer);
  std::vector<cv::Point> corners_px;
  const float limit = 4.0F * static_cast<float>(size.width);
  for (const cv::Point2f& p : now) {
    corners_px.emplace_back(static_cast<int>(std::clamp(p.x, -limit, limit)),
                            static_cast<int>(std::clamp(p.y, -limit, limit)));
  }
  s->seen.create(size, CV_8UC1);
  s->seen.setTo(0);
  cv::fillConvexPoly(s->seen, corners_px, cv::Scalar(255));
}

/// How far each pixel lies outside of what the layer brings within a pixel of it, in levels. What
/// it brings from outside the earlier picture is not known and contradicts nothing.
void measure_excess(const cv::Matx33d& layer, BackgroundState* s) {
  find_seen(layer, s);
  const cv::Mat& now = picture(*s, 0);
  cv::warpPerspective(
      picture(*s, s->age), s->warped, layer, now.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::dilate(s->warped, s->high, cv::Mat());
  cv::erode(s->warped, s->low, cv::Mat());
  s->excess.create(now.size(), CV_8UC1);
  for (int row = 0; row < now.rows; ++row) {
    const std::uint8_t* p = now.ptr<std::uint8_t>(row);
    const std::uint8_t* high = s->high.ptr<std::uint8_t>(row);
    const std::uint8_t* low = s->low.ptr<std::uint8_t>(row);
    const std::uint8_t* seen = s->seen.ptr<std::uint8_t>(row);
    std::uint8_t* out = s->excess.ptr<std::uint8_t>(row);
    for (int column = 0; column < now.cols; ++column) {
      out[column] = static_cast<std::uint8_t>(
          std::max({p[column] - high[column], low[column] - p[column], 0}) & seen[column]);
    }
  }
}

/// One sigma of a pixel's noise, by the median difference to the warped picture: most of the
/// picture is background or plain.
double measure_noise(const cv::Mat& now, const cv::Mat& warped) {
  std::array<int, 256> counts{};
  int total = 0;
  for (int row = 1; row < now.rows; row += 3) {
    const std::uint8_t* a = now.ptr<std::uint8_t>(row);
    const std::uint8_t* b = warped.ptr<std::uint8_t>(row);
    for (int column = 1; column < now.cols; column += 3) {
      if (a[column] > 8) {  // black pixels have no noise: it is cut off at zero
        ++counts[static_cast<std::size_t>(std::abs(a[column] - b[column]))];
        ++total;
      }
    }
  }
  int below = 0;
  std::size_t level = 0;
  while (level + 1 < counts.size() && 2 * (below += counts[level]) < total) {
    ++level;
  }
  return std::clamp(static_cast<double>(level) * 1.4826 / std::sqrt(2.0), 1.0, 8.0);
}

/// @return part of the picture that contradicts all layers.
double weigh(BackgroundState* s) {
  const cv::Mat& now = picture(*s, 0);
  cv::morphologyEx(now, s->texture, cv::MORPH_GRADIENT, cv::Mat());
  // The target sweeps over what was background a moment ago, and where it turns towards the camera
  // it moves little: agreement weighs less than contradiction, and is not remembered for long.
  constexpr float kBackgroundStep = 0.3F;
  constexpr float kBackgroundMax = 1.5F;
  constexpr float kFading = 0.97F;
  const auto limit = static_cast<float>(3.0 * s->noise);
  const auto plain = static_cast<float>(8.0 * s->noise);
  std::int64_t contradicting = 0;
  for (int row = 0; row < now.rows; ++row) {
    const std::uint8_t* excess = s->excess_least.ptr<std::uint8_t>(row);
    const std::uint8_t* texture = s->texture.ptr<std::uint8_t>(row);
    auto* evidence = s->evidence.ptr<float>(row);
    auto* instant = s->instant.ptr<float>(row);
    for (int column = 0; column < now.cols; ++column) {
      const float over = static_cast<float>(excess[column]) - limit;
      if (over > 0.0F) {
        instant[column] = 1.0F;
        evidence[column] += std::min(2.0F, 1.0F + over / limit);
        ++contradicting;
      } else if (static_cast<float>(texture[column]) > plain) {
        instant[column] = -1.0F;
        evidence[column] -= kBackgroundStep;
      } else {
        instant[column] = 0.0F;
        evidence[column] *= kFading;
      }
      evidence[column] =
          std::clamp(evidence[column], -kBackgroundMax, BackgroundState::kEvidenceMax);
    }
  }
  return static_cast<double>(contradicting) / static_cast<double>(now.total());
}

/// Too little change: compare with an older picture next time; too much: with a younger one, whose
/// target covers other places less.
void choose_age(double contradicting, BackgroundState* s) {
  constexpr double kLittle = 0.01;
  constexpr double kMuch = 0.04;
  if (contradicting < kLittle) {
    s->age = std::min(s->age + 1, BackgroundState::kPictures - 1);
  } else if (contradicting > kMuch && s->age > 1) {
    --s->age;
  }
}

}  // namespace

void clear(BackgroundState* state) {
  state->stored = 0;
  state->age = 1;
  state->tracks.clear();
  state->layers.clear();
}

void add_picture(const cv::Mat& gray, BackgroundState* s) {
  const int decimation = (gray.cols + kWidthMax - 1) / kWidthMax;
  const cv::Size size(gray.cols / decimation, gray.rows / decimation);
  if (decimation != s->decimation || s->evidence.size() != size) {
    clear(s);
    s->decimation = decimation;
    s->evidence.create(size, CV_32FC1);
    s->evidence.setTo(0.0);
    s->instant.create(size, CV_32FC1);
  }
  s->instant.setTo(0.0);
  s->newest = (s->newest + 1) % BackgroundState::kPictures;
  s->stored = std::min(s->stored + 1, BackgroundState::kPictures);
  const cv::Mat whole = gray(cv::Rect(0, 0, size.width * decimation, size.height * decimation));
  cv::resize(whole, s->pictures[s->newest], size, 0.0, 0.0, cv::INTER_AREA);
  find_corners(s->pictures[s->newest], &s->corner_score, &s->corners[s->newest]);
}

bool compare_pictures(const cv::Mat& target, BackgroundState* s) {
  s->tracks.clear();
  s->layers.clear();
  if (s->stored < 2) {
    return false;
  }
  s->age = std::min(s->age, s->stored - 1);
  follow(target, s);
  fit_layers(s);
  if (s->layers.empty()) {
    s->age = s->age > 1 ? s->age - 1 : s->age;
    return false;
  }
  for (std::size_t i = 0; i < s->layers.size(); ++i) {
    measure_excess(s->layers[i], s);
    if (i == 0) {
      s->noise = 0.5 * s->noise + 0.5 * measure_noise(picture(*s, 0), s->warped);
      cv::swap(s->excess, s->excess_least);
    } else {
      cv::min(s->excess, s->excess_least, s->excess_least);
    }
  }
  choose_age(weigh(s), s);
  return true;
}

}  // namespace polhode
