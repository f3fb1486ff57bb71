#include "mask/background.hpp"

#include <algorithm>
#include <cmath>

#include "base/median.hpp"
#include "mask/plane_motion.hpp"

namespace polhode {
namespace {

// Gate of a layer: points are tracked to 0.2 px, so three sigma of that (99 % in two directions),
// and 0.4 px for surfaces that are not quite plane.
constexpr double kFit_px = 1.0;
// Distance from which a point contradicts the background: half as much again as the gate. Chosen;
// larger needs faster targets, smaller takes mistracked points for the target.
constexpr float kContradiction_px = 1.5F;
constexpr std::size_t kAgeMax = (MaskTrack::kPlaces - 1) / 2;  // twice the age is compared, too

/// Does a group of points surround the middle, as a background does? By 4 x 4 blocks of the image:
/// it is in at least three of the 12 outer ones and covers as much of them as of the inner ones.
/// Coverage is counted in quarters of a block, as points are closer together on the target.
bool surrounds(const std::vector<cv::Point2f>& points, const cv::Size& size) {
  // Chosen; larger misses a background beside a large target, smaller takes a face for one.
  constexpr int kOuterBlocksMin = 3;
  constexpr int kQuarters = 8;  // two along a block's side
  std::array<bool, kQuarters * kQuarters> covered{};
  std::array<bool, 16> block{};
  int outer = 0;
  int inner = 0;
  for (const cv::Point2f& p : points) {
    const int column = std::clamp(static_cast<int>(p.x) * kQuarters / size.width, 0, kQuarters - 1);
    const int row = std::clamp(static_cast<int>(p.y) * kQuarters / size.height, 0, kQuarters - 1);
    bool& quarter = covered[static_cast<std::size_t>(kQuarters * row + column)];
    if (quarter) {
      continue;
    }
    quarter = true;
    const bool at_border = std::min(column, row) < 2 || std::max(column, row) >= kQuarters - 2;
    (at_border ? outer : inner) += 1;
    block[static_cast<std::size_t>(4 * (row / 2) + column / 2)] =
        at_border || block[static_cast<std::size_t>(4 * (row / 2) + column / 2)];
  }
  return std::count(block.begin(), block.end(), true) >= kOuterBlocksMin && outer >= inner;
}

/// Collects the points that are known over the whole age and are not on known parts of the target.
void gather(const cv::Mat& target,
            int step,
            std::size_t age,
            const PointsState& points,
            BackgroundState* s) {
  s->from.clear();
  s->to.clear();
  for (const MaskTrack& track : points.tracks) {
    if (track.count > age &&
        (target.empty() || target.at<std::uint8_t>(cv::Point(track.now()) / step) == 0)) {
      s->from.push_back(track.places[age]);
      s->to.push_back(track.now());
    }
  }
}

/// Moves the points that agree with a motion from `left` to `group`.
void take_out_agreeing(BackgroundState* s) {
  std::size_t kept = 0;
  s->group.clear();
  for (std::size_t i = 0; i < s->from.size(); ++i) {
    if (s->agrees[i] != 0) {
      s->group.push_back(s->to[i]);
    } else {
      s->from[kept] = s->from[i];
      s->to[kept++] = s->to[i];
    }
  }
  s->from.resize(kept);
  s->to.resize(kept);
}

/// Fits one plane motion after the other, each to the remaining points. A group that does not
/// surround the middle is a face of the target and becomes no layer.
void fit_layers(const cv::Size& size, BackgroundMotion* motion, BackgroundState* s) {
  constexpr int kGroupsMax = static_cast<int>(BackgroundMotion::kLayers) + 1;  // one face of it
  motion->layers.clear();
  for (int group = 0; group < kGroupsMax && !motion->layers.full(); ++group) {
    if (s->from.size() < BackgroundMotion::kLayerTracksMin) {
      return;
    }
    cv::Matx33d layer;
    if (!fit_plane_motion(s->from, s->to, kFit_px, &layer, &s->agrees)) {
      return;
    }
    take_out_agreeing(s);
    if (s->group.size() < BackgroundMotion::kLayerTracksMin) {
      return;
    }
    if (surrounds(s->group, size)) {
      (void)motion->layers.push_back(layer);
    }
  }
}

/// Distance of a point from its nearest position by the background's motions.
float contradiction_px(const MaskTrack& track, const BackgroundMotion& motion) {
  float least = 1E6F;  // beyond any distance in an image
  for (const cv::Matx33d& layer : motion.layers) {
    const cv::Point2f d = track.now() - moved(layer, track.places[motion.age]);
    least = std::min(least, std::hypot(d.x, d.y));
  }
  return least;
}

void classify(const BackgroundState& s, PointsState* points) {
  for (MaskTrack& track : points->tracks) {
    track.kind = TrackClass::kUnassigned;
    for (const BackgroundMotion& motion : s.motions) {
      if (motion.layers.empty() || track.count <= motion.age) {
        continue;
      }
      const bool contradicts = contradiction_px(track, motion) > kContradiction_px;
      track.kind = contradicts || track.kind == TrackClass::kTarget ? TrackClass::kTarget
                                                                    : TrackClass::kBackground;
    }
  }
}

/// Unassigns isolated points of the target, and those with three times as many of the background
/// near: they are mistracked.
void drop_lonely(PointsState* points) {
  // Radius of the neighbourhood: 32 px of 640, about the spacing of the image's points. Chosen;
  // larger keeps mistracked points, smaller drops those of small targets.
  const float reach = static_cast<float>(points->whole().width) / 20.0F;
  constexpr int kTargetMin = 2;        // with itself
  constexpr int kBackgroundTimes = 3;  // as around a right-angled corner of the body
  for (MaskTrack& track : points->tracks) {
    if (track.kind != TrackClass::kTarget) {
      continue;
    }
    int target = 0;
    int background = 0;
    for (const MaskTrack& other : points->tracks) {
      const cv::Point2f d = other.now() - track.now();
      if (std::max(std::abs(d.x), std::abs(d.y)) < reach) {
        target += other.kind == TrackClass::kTarget ? 1 : 0;
        background += other.kind == TrackClass::kBackground ? 1 : 0;
      }
    }
    if (target < kTargetMin || kBackgroundTimes * target < background) {
      track.kind = TrackClass::kUnassigned;
    }
  }
}

}  // namespace

bool explain_background(
    const cv::Mat& target, int step, FittedAges ages, PointsState* points, BackgroundState* s) {
  s->target_tracks = 0;
  const std::size_t longest = points->stored - 1;
  s->age = std::clamp(s->age, std::size_t{1}, std::max(longest, std::size_t{1}));
  for (std::size_t i = 0; i < s->motions.size(); ++i) {
    s->motions[i].age = (i + 1) * s->age;
    s->motions[i].layers.clear();
  }
  const auto fitted = [&](BackgroundMotion* motion) {
    if (motion->age <= longest) {
      gather(target, step, motion->age, *points, s);
      fit_layers(points->whole().size(), motion, s);
    }
    return !motion->layers.empty();
  };
  auto& [shorter, longer] = s->motions;
  bool explained = fitted(ages == FittedAges::kLonger ? &longer : &shorter);
  if (!explained || ages == FittedAges::kBoth) {
    explained = fitted(ages == FittedAges::kLonger ? &shorter : &longer) || explained;
  }
  classify(*s, points);
  drop_stray_points(TrackClass::kTarget, points);
  drop_lonely(points);
  s->target_tracks = static_cast<std::size_t>(
      std::count_if(points->tracks.begin(), points->tracks.end(), [](const MaskTrack& track) {
        return track.kind == TrackClass::kTarget;
      }));
  return explained;
}

void choose_age(const PointsState& points, BackgroundState* s) {
  constexpr float kLittle_px = kContradiction_px;
  // Motion above which the age is lowered: over twice that for raising it, so that the age does not
  // alternate. Chosen; larger widens the uncovered strip behind the target.
  constexpr float kMuch_px = 4.0F;
  // Least points. Chosen: the median of fewer is one of them.
  constexpr std::size_t kTracksMin = 4;
  const auto* const motion =
      std::find_if(s->motions.begin(), s->motions.end(), [](const BackgroundMotion& m) {
        return !m.layers.empty();
      });
  if (motion == s->motions.end()) {
    s->age = std::max(s->age - 1, std::size_t{1});
    return;
  }
  std::vector<float>& px = s->contradictions_px;
  px.clear();
  for (const MaskTrack& track : points.tracks) {
    if (track.kind == TrackClass::kTarget && track.count > motion->age) {
      px.push_back(contradiction_px(track, *motion));
    }
  }
  if (px.size() < kTracksMin) {
    s->age = std::min(s->age + 1, kAgeMax);
    return;
  }
  const auto ages = static_cast<float>(motion->age / s->age);
  const float typical_px = median(std::span(px)) / ages;
  if (typical_px < kLittle_px) {
    s->age = std::min(s->age + 1, kAgeMax);
  } else if (typical_px > kMuch_px && s->age > 1) {
    --s->age;
  }
}

void clear(BackgroundState* s) {
  s->age = 1;
  for (BackgroundMotion& motion : s->motions) {
    motion.layers.clear();
  }
  s->target_tracks = 0;
}

}  // namespace polhode
