#include "mask/points.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <span>
#include <utility>

#include "base/median.hpp"
#include "mask/shrink.hpp"

namespace polhode {
namespace {

// Window of the optical flow. 11 px take 0.6 ms more and give similar poses; 7 px are no cheaper by
// a tenth (decision 0013).
constexpr int kFlowWindow_px = 9;
// Three halvings: a point is found within about 8 half windows, 36 px.
constexpr int kFlowLevels = 3;
// The search for a point with a known motion starts at the prediction: within half a window, on one
// level.
constexpr int kLevelsPredicted = 0;
// Points that are closer share half of their windows' width or more.
constexpr int kNearest_px = 5;
// Motions are separated by 1 px and more. 0.02 px takes 0.3 ms more; 0.1 px saves nothing (decision
// 0013).
constexpr double kSettled_px = 0.05;
// Iterations for a point on a level; half as many save nothing (decision 0013).
constexpr int kIterationsMax = 15;

void clear_flow(PointsState* s) {
  s->from.clear();
  s->to.clear();
  s->found.clear();
  s->error.clear();
}

void add_to_flow(const cv::Point2f& from, const cv::Point2f& guess, PointsState* s) {
  s->from.push_back(from);
  s->to.push_back(guess);
  s->found.push_back(0);
  s->error.push_back(0.0F);
}

/// Optical flow of a range of the points in `from`, with initial values in `to`.
void flow(const FlowPyramid& before,
          const FlowPyramid& after,
          const cv::Range& points,
          int levels,
          PointsState* s) {
  if (points.empty()) {
    return;
  }
  const auto part = [&](auto* all) { return cv::Mat(*all).rowRange(points); };
  cv::calcOpticalFlowPyrLK(
      before,
      after,
      part(&s->from),
      part(&s->to),
      part(&s->found),
      part(&s->error),
      cv::Size(kFlowWindow_px, kFlowWindow_px),
      levels,
      cv::TermCriteria(
          cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kIterationsMax, kSettled_px),
      cv::OPTFLOW_USE_INITIAL_FLOW);
}

/// Third quartile of the differences of the first `count` points, levels. The median would not show
/// the loss of half of them (decision 0013). 255 when no point was found.
float typical_error(int count, PointsState* s) {
  constexpr float kLargest = 255.0F;  // of 8-bit levels
  std::size_t found = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    if (s->found[i] != 0) {
      s->error[found++] = s->error[i];
    }
  }
  return found > 0 ? ranked(std::span(s->error).first(found), 3 * found / 4) : kLargest;
}

/// Tracks points with a known motion from its prediction. When they suddenly differ more than in
/// the image before, the motion has changed: an image is missing, or the camera has been rotated.
/// Then the search range is that of new points.
void flow_with_prediction(int known, PointsState* s) {
  // Ratio of the difference to the last image's (decision 0013). Larger misses changes of motion,
  // smaller searches in vain.
  constexpr float kLessAlike = 2.0F;
  constexpr float kLevelsOff = 1.0F;  // images without noise are rounded to levels
  const int all = static_cast<int>(s->from.size());
  int done = known;
  flow(s->pyramid_before, s->pyramid, {0, known}, kLevelsPredicted, s);
  const float error = typical_error(known, s);
  if (error > kLessAlike * s->error_before + kLevelsOff) {
    done = 0;
    s->to = s->from;
  }
  flow(s->pyramid_before, s->pyramid, {done, all}, kFlowLevels, s);
  s->error_before = done == 0 ? typical_error(known, s) : error;
}

bool inside(const cv::Point2f& p, const cv::Size& size) {
  // Border left out: gradients and corner scores there are of repeated pixels.
  constexpr float kBorder_px = 2.0F;
  return p.x > kBorder_px && p.y > kBorder_px &&
         p.x < static_cast<float>(size.width) - 1.0F - kBorder_px &&
         p.y < static_cast<float>(size.height) - 1.0F - kBorder_px;
}

void advance(const cv::Point2f& to, MaskTrack* track) {
  std::copy_backward(track->places.begin(), track->places.end() - 1, track->places.end());
  track->places[0] = to;
  track->count = std::min(track->count + 1, MaskTrack::kPlaces);
}

bool is_near(const cv::Point2f& p, const PointsState& s) {
  return std::any_of(s.tracks.begin(), s.tracks.end(), [&](const MaskTrack& track) {
    const cv::Point2f d = track.now() - p;
    return std::abs(d.x) < static_cast<float>(kNearest_px) &&
           std::abs(d.y) < static_cast<float>(kNearest_px);
  });
}

/// Adds the best corner of each tile of a grid over part of the image, until there are `most`
/// points.
void add_corners(const cv::Rect& part, int columns, int rows, std::size_t most, PointsState* s) {
  // Least score. A step of 20 levels at a corner has 5e-4; noise of 2 levels gives a tenth of that.
  constexpr double kScoreMin = 2E-4;
  if (part.width < columns || part.height < rows || s->tracks.size() >= most) {
    return;
  }
  constexpr int kBlock_px = 3;  // the least, for corners of small texture
  cv::cornerMinEigenVal(s->image(0)(part), s->corner_score, kBlock_px, kBlock_px);
  // A step through the tiles, so that tiles left out when the table is full are spread evenly. A
  // prime, so that it meets each of the 60, 72 or 144 tiles once.
  constexpr int kStride = 37;
  const int tiles = rows * columns;
  for (int i = 0; i < tiles && s->tracks.size() < most; ++i) {
    const int r = (i * kStride % tiles) / columns;
    const int c = (i * kStride % tiles) % columns;
    const cv::Rect tile(cv::Point(c * part.width / columns, r * part.height / rows),
                        cv::Point((c + 1) * part.width / columns, (r + 1) * part.height / rows));
    double best = 0.0;
    cv::Point where;
    cv::minMaxLoc(s->corner_score(tile), nullptr, &best, nullptr, &where);
    MaskTrack track;
    track.places[0] = cv::Point2f(where + tile.tl() + part.tl());
    track.count = 1;
    if (best > kScoreMin && inside(track.now(), s->image(0).size()) && !is_near(track.now(), *s)) {
      (void)s->tracks.push_back(track);
    }
  }
}

}  // namespace

cv::Point2f MaskTrack::motion(std::size_t age) const {
  const std::size_t known = std::min(age, count - 1);
  if (known == 0) {
    return {};
  }
  return (places[0] - places[known]) * (static_cast<float>(age) / static_cast<float>(known));
}

bool add_image(const cv::Mat& gray, const cv::Mat& reduced, PointsState* s) {
  const int decimation = decimation_of(gray.cols, gray.rows);
  const cv::Size size(gray.cols / decimation, gray.rows / decimation);
  if (s->stored > 0 && (decimation != s->decimation || s->image(0).size() != size)) {
    clear(s);
  }
  s->decimation = decimation;
  s->newest = (s->newest + 1) % PointsState::kImages;
  s->stored = std::min(s->stored + 1, PointsState::kImages);
  cv::Mat& newest = s->images[s->newest];
  if (reduced.size() == size && size * decimation == gray.size()) {
    reduced.copyTo(newest);
  } else {
    shrink(gray(cv::Rect({}, size * decimation)), size, decimation, &newest);
  }
  std::swap(s->pyramid, s->pyramid_before);
  cv::buildOpticalFlowPyramid(
      s->image(0), s->pyramid, cv::Size(kFlowWindow_px, kFlowWindow_px), kFlowLevels, true);
  return s->stored == 1;
}

void follow_points(PointsState* s) {
  if (s->tracks.empty() || s->stored < 2) {
    s->tracks.clear();
    return;
  }
  clear_flow(s);
  int known = 0;  // new points come last
  for (const MaskTrack& track : s->tracks) {
    const bool is_predicted = s->predicted && track.count > 1;
    add_to_flow(track.now(), is_predicted ? track.now() + track.motion(1) : track.now(), s);
    known += is_predicted ? 1 : 0;
  }
  flow_with_prediction(known, s);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s->tracks.size(); ++i) {
    if (s->found[i] != 0 && inside(s->to[i], s->image(0).size())) {
      MaskTrack track = s->tracks[i];
      advance(s->to[i], &track);
      s->tracks[kept++] = track;
    }
  }
  s->tracks.resize(kept);
}

void drop_stray_points(TrackClass kind, PointsState* s) {
  // Largest error of tracking forth and back: about half of the distance that contradicts the
  // background (1.5 px). Chosen; larger keeps mistracked points, smaller drops noisy ones.
  constexpr float kStray_px = 0.7F;
  clear_flow(s);
  for (const MaskTrack& track : s->tracks) {
    if (track.kind == kind && track.count > 1) {
      add_to_flow(track.now(), s->predicted ? track.places[1] : track.now(), s);
    }
  }
  const cv::Range all(0, static_cast<int>(s->from.size()));
  flow(s->pyramid, s->pyramid_before, all, s->predicted ? kLevelsPredicted : kFlowLevels, s);
  std::size_t kept = 0;
  std::size_t asked = 0;
  for (std::size_t i = 0; i < s->tracks.size(); ++i) {
    const MaskTrack track = s->tracks[i];
    if (track.kind == kind && track.count > 1) {
      const cv::Point2f d = s->to[asked] - track.places[1];
      const bool back = s->found[asked] != 0 && std::hypot(d.x, d.y) < kStray_px;
      ++asked;
      if (!back) {
        continue;
      }
    }
    s->tracks[kept++] = track;
  }
  s->tracks.resize(kept);
}

void refill_points(const cv::Rect& target, Refill where, PointsState* s) {
  // Tiles of 32 x 30 px in an image of 640 x 360, a quarter of them at a time. Chosen; more tiles
  // cost time, fewer leave a background's plane with few points.
  constexpr int kColumns = 20;
  constexpr int kBands = 4;
  constexpr int kRowsOfBand = 3;
  // Rows and columns of the finer grid: tiles of kCell_px of the target's motion for one of 100 px.
  constexpr int kOnTarget = 12;
  // 144 tiles, and points that have moved on in them. Chosen; with the image's 240 tiles it fills
  // kTracks.
  constexpr std::size_t kOnTargetMost = 200;
  const cv::Rect whole = s->whole();
  const auto there = static_cast<std::size_t>(
      std::count_if(s->tracks.begin(), s->tracks.end(), [&](const MaskTrack& track) {
        return target.contains(cv::Point(track.now()));
      }));
  const bool by_turns = where == Refill::kByTurns;
  const std::size_t most = s->tracks.size() + kOnTargetMost - std::min(there, kOnTargetMost);
  const cv::Rect visible = target & whole;
  if (!by_turns || there < kOnTargetMost / 2) {
    add_corners(visible, kOnTarget, kOnTarget, most, s);
  } else if (s->turn % 2 == 0) {
    const int half = visible.height / 2;
    const bool lower = s->turn % 4 != 0;
    const cv::Rect part(visible.x, visible.y + (lower ? half : 0), visible.width, half);
    add_corners(part, kOnTarget, kOnTarget / 2, most, s);
  }
  for (int band = 0; band < kBands; ++band) {
    const bool turn_of_band =
        s->turn / 2 == static_cast<std::size_t>(band) && (!by_turns || s->turn % 2 == 1);
    if (where == Refill::kEverywhere || turn_of_band) {
      const int top = band * whole.height / kBands;
      const int bottom = (band + 1) * whole.height / kBands;
      add_corners(
          {0, top, whole.width, bottom - top}, kColumns, kRowsOfBand, PointsState::kTracks, s);
    }
  }
  s->turn = (s->turn + (by_turns ? 1 : 2)) % (2 * kBands);
}

void clear(PointsState* s) {
  s->stored = 0;
  s->turn = 0;
  s->error_before = 0.0F;
  s->tracks.clear();
}

}  // namespace polhode
