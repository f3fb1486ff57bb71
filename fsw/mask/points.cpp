#include "mask/points.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "mask/shrink.hpp"

namespace polhode {
namespace {

constexpr int kWindow_px = 9;
constexpr int kLevels = 3;
constexpr int kNearest_px = 5;  // closer together, two points tell the same
// Motions are told apart by 1 px and more.
constexpr double kSettled_px = 0.05;

void flow(const FlowPyramid& from, const FlowPyramid& to, PointsState* s) {
  cv::calcOpticalFlowPyrLK(
      from,
      to,
      s->from,
      s->to,
      s->found,
      s->error,
      cv::Size(kWindow_px, kWindow_px),
      kLevels,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, kSettled_px));
}

bool inside(const cv::Point2f& p, const cv::Size& size) {
  constexpr float kRim_px = 2.0F;
  return p.x > kRim_px && p.y > kRim_px && p.x < static_cast<float>(size.width) - 1.0F - kRim_px &&
         p.y < static_cast<float>(size.height) - 1.0F - kRim_px;
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

/// The best corner of each tile of a grid over part of the picture, until there are so many points.
void add_corners(const cv::Rect& part, int columns, int rows, std::size_t most, PointsState* s) {
  // A step of 20 levels at a corner has 5e-4; noise of 2 levels gives a tenth of that.
  constexpr double kScoreMin = 2E-4;
  if (part.width < columns || part.height < rows) {
    return;
  }
  cv::cornerMinEigenVal(s->picture(0)(part), s->corner_score, 3, 3);
  // In an order that is spread over the part: what is left out when it is full is so, too.
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
    if (best > kScoreMin && inside(track.now(), s->picture(0).size()) &&
        !is_near(track.now(), *s)) {
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

bool add_picture(const cv::Mat& gray, PointsState* s) {
  const int decimation = decimation_of(gray.cols);
  const cv::Size size(gray.cols / decimation, gray.rows / decimation);
  if (s->stored > 0 && (decimation != s->decimation || s->picture(0).size() != size)) {
    clear(s);
  }
  s->decimation = decimation;
  s->newest = (s->newest + 1) % PointsState::kPictures;
  s->stored = std::min(s->stored + 1, PointsState::kPictures);
  shrink(gray(cv::Rect({}, size * decimation)), size, decimation, &s->pictures[s->newest]);
  std::swap(s->pyramid, s->pyramid_before);
  cv::buildOpticalFlowPyramid(
      s->picture(0), s->pyramid, cv::Size(kWindow_px, kWindow_px), kLevels, true);
  return s->stored == 1;
}

void follow_points(PointsState* s) {
  if (s->tracks.empty() || s->stored < 2) {
    s->tracks.clear();
    return;
  }
  s->from.clear();
  for (const MaskTrack& track : s->tracks) {
    s->from.push_back(track.now());
  }
  flow(s->pyramid_before, s->pyramid, s);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s->tracks.size(); ++i) {
    if (s->found[i] != 0 && inside(s->to[i], s->picture(0).size())) {
      MaskTrack track = s->tracks[i];
      advance(s->to[i], &track);
      s->tracks[kept++] = track;
    }
  }
  s->tracks.resize(kept);
}

void drop_stray_points(TrackClass kind, PointsState* s) {
  constexpr float kStray_px = 0.7F;
  s->from.clear();
  for (const MaskTrack& track : s->tracks) {
    if (track.kind == kind && track.count > 1) {
      s->from.push_back(track.now());
    }
  }
  if (s->from.empty()) {
    return;
  }
  flow(s->pyramid, s->pyramid_before, s);
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
  constexpr int kColumns = 20;
  constexpr int kBands = 4;
  constexpr int kRowsOfBand = 3;
  constexpr int kOnTarget = 12;  // rows and columns of the finer grid
  constexpr std::size_t kOnTargetMost = 200;
  const cv::Rect whole = s->whole();
  const auto there = static_cast<std::size_t>(
      std::count_if(s->tracks.begin(), s->tracks.end(), [&](const MaskTrack& track) {
        return target.contains(cv::Point(track.now()));
      }));
  const bool by_turns = where == Refill::kByTurns;
  const bool turn_of_target = !by_turns || s->turn % 2 == 0 || there < kOnTargetMost / 2;
  if (turn_of_target && there < kOnTargetMost) {
    const std::size_t most = s->tracks.size() + kOnTargetMost - there;
    add_corners(target & whole, kOnTarget, kOnTarget, most, s);
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
  s->tracks.clear();
}

}  // namespace polhode
