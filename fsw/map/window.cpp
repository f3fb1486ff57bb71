#include "map/window.hpp"

#include <algorithm>
#include <array>

#include "base/median.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

// Factor on the sigma of observations of unconfirmed landmarks. Measured on nine rendered
// sequences: at 1 a spinning body is lost to glints, at 3 young maps are constrained too weakly.
constexpr double kUnconfirmedSigma = 2.4;

using Slots = std::array<std::int32_t, limits::kLandmarks>;
using KeyframeIds = FixedVector<KeyframeId, limits::kKeyframes>;

int shared_landmarks(const Keyframe& keyframe, const std::array<bool, limits::kLandmarks>& wanted) {
  int shared = 0;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    shared += id.valid() && wanted[id.index()] ? 1 : 0;
  }
  return shared;
}

void collect_landmarks(const Keyframe& keyframe, std::array<bool, limits::kLandmarks>* wanted) {
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i].valid()) {
      (*wanted)[keyframe.landmark_of[i].index()] = true;
    }
  }
}

/// Keyframes by the number of wanted landmarks that they see, most first, newest first among
/// equals.
KeyframeIds by_covisibility(const Map& map,
                            const std::array<bool, limits::kLandmarks>& wanted,
                            const KeyframeIds& except) {
  struct Ranked {
    int shared = 0;
    std::uint32_t number = 0;
    KeyframeId id;
  };
  FixedVector<Ranked, limits::kKeyframes> ranked;
  for (const KeyframeId id : keyframes_by_age(map)) {
    const Keyframe& keyframe = map.keyframes[id.index()];
    const int shared = shared_landmarks(keyframe, wanted);
    if (shared > 0 && std::find(except.begin(), except.end(), id) == except.end()) {
      (void)ranked.push_back({.shared = shared, .number = keyframe.number, .id = id});
    }
  }
  std::sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
    return a.shared != b.shared ? a.shared > b.shared : a.number > b.number;
  });
  KeyframeIds ids;
  for (const Ranked& entry : ranked) {
    (void)ids.push_back(entry.id);
  }
  return ids;
}

void begin(const Map& map, AdjustmentSnapshot* s) {
  s->next_keyframe_number = map.next_keyframe_number;
  s->next_landmark_number = map.next_landmark_number;
  s->keyframes.clear();
  s->keyframe_numbers.clear();
  s->poses.clear();
  s->pose_fixed.clear();
  s->timestamps_ns.clear();
  s->R_IC.clear();
  s->motion.priors.clear();
  s->motion.links.clear();
  s->landmarks.clear();
  s->landmark_numbers.clear();
  s->points_T.clear();
  s->point_fixed.clear();
  s->observations.clear();
  s->left_out = 0;
}

void add_pose(const Map& map, KeyframeId id, bool fixed, AdjustmentSnapshot* s) {
  (void)s->keyframes.push_back(id);
  (void)s->keyframe_numbers.push_back(map.keyframes[id.index()].number);
  (void)s->poses.push_back(to_inverse_depth(map.keyframes[id.index()].pose));
  (void)s->pose_fixed.push_back(fixed ? 1 : 0);
  (void)s->timestamps_ns.push_back(map.keyframes[id.index()].timestamp_ns);
  (void)s->R_IC.push_back(map.keyframes[id.index()].R_IC);
}

/// Points in slot order and observations in keyframe order: the solver sees the same problem in the
/// same order each time.
void add_points(const Map& map,
                const CameraModel& camera,
                const std::array<bool, limits::kLandmarks>& wanted,
                AdjustmentSnapshot* s) {
  Slots index{};
  index.fill(-1);
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (wanted[i] && map.landmarks[i].used && map.landmarks[i].observations >= 2) {
      index[i] = static_cast<std::int32_t>(s->points_T.size());
      (void)s->landmarks.push_back(LandmarkId::from_index(i));
      (void)s->landmark_numbers.push_back(map.landmarks[i].number);
      (void)s->points_T.push_back(map.landmarks[i].p_T);
      (void)s->point_fixed.push_back(0);
    }
  }
  for (std::size_t k = 0; k < s->keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[s->keyframes[k].index()];
    for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      if (id.valid() && index[id.index()] >= 0) {
        const Feature& f = keyframe.features[i];
        const double trust = confirmed(map.landmarks[id.index()]) ? 1.0 : kUnconfirmedSigma;
        const bool stored = s->observations.push_back(
            {.pose = static_cast<std::int32_t>(k),
             .point = index[id.index()],
             .normalised = f.normalised,
             .sigma_normalised = trust * static_cast<double>(f.sigma_px) / camera.focal_px()});
        s->left_out += stored ? 0 : 1;
      }
    }
  }
}

/// Slots are used again: does the slot still have the landmark of the snapshot?
bool is_there(const AdjustmentSnapshot& s, std::size_t i, const Map& map) {
  const Landmark& landmark = map.landmarks[s.landmarks[i].index()];
  return landmark.used && landmark.number == s.landmark_numbers[i];
}

/// Median over the landmarks that are still there.
template <typename ValueOf>
double median_of(const AdjustmentSnapshot& s, const Map& map, const ValueOf& value_of) {
  FixedVector<double, limits::kLandmarks> values;
  for (std::size_t i = 0; i < s.landmarks.size(); ++i) {
    if (is_there(s, i, map)) {
      (void)values.push_back(value_of(i));
    }
  }
  return median(values.view());
}

/// Similarity from the adjusted map back to the original, by medians. An adjustment leaves scale
/// and origin free, so they may drift by any factor. A landmark with two observations may, too, and
/// would bias a least-squares fit.
Similarity back_by_medians(const AdjustmentSnapshot& s,
                           const Map& map,
                           const Eigen::Matrix3d& R_back) {
  const auto before = [&](std::size_t i) { return map.landmarks[s.landmarks[i].index()].p_T; };
  const auto adjusted = [&](std::size_t i) -> Eigen::Vector3d { return R_back * s.points_T[i]; };
  Eigen::Vector3d middle_before;
  Eigen::Vector3d middle_adjusted;
  for (int axis = 0; axis < 3; ++axis) {
    middle_before[axis] = median_of(s, map, [&](std::size_t i) { return before(i)[axis]; });
    middle_adjusted[axis] = median_of(s, map, [&](std::size_t i) { return adjusted(i)[axis]; });
  }
  const double size_before =
      median_of(s, map, [&](std::size_t i) { return (before(i) - middle_before).norm(); });
  const double size_adjusted =
      median_of(s, map, [&](std::size_t i) { return (adjusted(i) - middle_adjusted).norm(); });
  const double scale = size_adjusted > 0.0 ? size_before / size_adjusted : 1.0;
  return {.scale = scale, .R_ba = R_back, .t_ba = middle_before - scale * middle_adjusted};
}

bool is_there(const AdjustmentSnapshot& s, std::size_t k, const Keyframe& keyframe) {
  return keyframe.used && keyframe.number == s.keyframe_numbers[k];
}

/// The rotation of T that restores the keyframes' attitudes in the mean. Landmarks cannot give it:
/// removing the shear of a young map along its depth rotates them by half of it, while images and
/// attitudes stay.
Eigen::Matrix3d attitudes_back(const AdjustmentSnapshot& s, const Map& map) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < s.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[s.keyframes[k].index()];
    if (is_there(s, k, keyframe)) {
      sum += keyframe.pose.R_CT.transpose() * from_inverse_depth(s.poses[k]).R_CT;
    }
  }
  return nearest_rotation(sum);
}

/// Similarity from the adjusted map back to the original; identity where fixed keyframes keep the
/// gauge.
Similarity back_onto(const AdjustmentSnapshot& s, const Map& map) {
  if (std::count(s.pose_fixed.begin(), s.pose_fixed.end(), std::uint8_t{1}) > 1) {
    return {};
  }
  // Of landmarks that belong to the adjusted map the farthest moves two or three medians.
  constexpr double kMedians = 5.0;
  const Similarity rough = back_by_medians(s, map, attitudes_back(s, map));
  const auto off_by = [&](std::size_t i) {
    return (rough.apply(s.points_T[i]) - map.landmarks[s.landmarks[i].index()].p_T).norm();
  };
  const double limit = kMedians * median_of(s, map, off_by);
  FixedVector<Eigen::Vector3d, limits::kLandmarks> adjusted;
  FixedVector<Eigen::Vector3d, limits::kLandmarks> before;
  FixedVector<double, limits::kLandmarks> weights;
  for (std::size_t i = 0; i < s.landmarks.size(); ++i) {
    if (is_there(s, i, map) && off_by(i) <= limit) {
      const Landmark& landmark = map.landmarks[s.landmarks[i].index()];
      (void)adjusted.push_back(s.points_T[i]);
      (void)before.push_back(landmark.p_T);
      (void)weights.push_back(landmark.observations);
    }
  }
  const Result<Similarity> aligned =
      align_rotated(adjusted.view(), before.view(), weights.view(), rough.R_ba);
  return aligned ? aligned.value() : Similarity{};
}

/// Correction by the newest of the snapshot's keyframes that are still in the map.
MapCorrection correction_of(const AdjustmentSnapshot& s, const Map& map) {
  MapCorrection correction;
  correction.back = back_onto(s, map);
  std::uint32_t newest = 0;
  for (std::size_t k = 0; k < s.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[s.keyframes[k].index()];
    if (is_there(s, k, keyframe) && keyframe.number >= newest) {
      newest = keyframe.number;
      correction = {.timestamp_ns = keyframe.timestamp_ns,
                    .frame = keyframe.frame,
                    .before = keyframe.pose,
                    .after = transformed(from_inverse_depth(s.poses[k]), correction.back),
                    .back = correction.back};
    }
  }
  return correction;
}

/// Is the body in front of every keyframe's camera, for those of the snapshot and those that move
/// along?
bool all_in_front(const AdjustmentSnapshot& s, const MapCorrection& correction, const Map& map) {
  const bool adjusted =
      std::all_of(s.poses.begin(), s.poses.end(), [&](const InverseDepthPose& pose) {
        return is_before_camera(transformed(from_inverse_depth(pose), correction.back));
      });
  return adjusted &&
         std::all_of(map.keyframes.begin(), map.keyframes.end(), [&](const Keyframe& k) {
           return !k.used || k.number < s.next_keyframe_number ||
                  is_before_camera(correction.moved(k.pose));
         });
}

void take_along(const AdjustmentSnapshot& s, const MapCorrection& correction, Map* map) {
  if (map->next_keyframe_number == s.next_keyframe_number) {
    return;
  }
  for (Keyframe& keyframe : map->keyframes) {
    if (keyframe.used && keyframe.number >= s.next_keyframe_number) {
      keyframe.pose = correction.moved(keyframe.pose);
    }
  }
  for (Landmark& landmark : map->landmarks) {
    if (landmark.used && landmark.number >= s.next_landmark_number) {
      landmark.p_T = correction.moved_point(landmark.p_T);
    }
  }
}

}  // namespace

void snapshot_window(const Map& map, const CameraModel& camera, int window, AdjustmentSnapshot* s) {
  begin(map, s);
  const auto order = keyframes_by_age(map);
  if (order.empty()) {
    return;
  }
  std::array<bool, limits::kLandmarks> wanted{};
  collect_landmarks(map.keyframes[order[0].index()], &wanted);
  KeyframeIds moving;
  (void)moving.push_back(order[0]);
  for (const KeyframeId id : by_covisibility(map, wanted, moving)) {
    if (static_cast<int>(moving.size()) < window) {
      (void)moving.push_back(id);
    }
  }
  for (const KeyframeId id : moving) {
    collect_landmarks(map.keyframes[id.index()], &wanted);
    add_pose(map, id, false, s);
  }
  const std::size_t held_max = 2 * static_cast<std::size_t>(window);
  for (const KeyframeId id : by_covisibility(map, wanted, moving)) {
    if (s->keyframes.size() < moving.size() + held_max) {
      add_pose(map, id, true, s);
    }
  }
  if (s->keyframes.size() == moving.size()) {
    s->pose_fixed.back() = 1;
  }
  add_points(map, camera, wanted, s);
}

void snapshot_all(const Map& map, const CameraModel& camera, AdjustmentSnapshot* s) {
  begin(map, s);
  std::array<bool, limits::kLandmarks> wanted{};
  wanted.fill(true);
  for (const KeyframeId id : keyframes_by_age(map)) {
    add_pose(map, id, s->keyframes.empty(), s);
  }
  add_points(map, camera, wanted, s);
}

BundleProblem problem_of(AdjustmentSnapshot* s) {
  return {.poses = s->poses.view(),
          .pose_fixed = s->pose_fixed.view(),
          .points_T = s->points_T.view(),
          .point_fixed = s->point_fixed.view(),
          .observations = s->observations.view(),
          .priors = s->motion.priors.view(),
          .R_IC = s->R_IC.view(),
          .links = s->motion.links.view()};
}

BundleReport adjust(AdjustmentSnapshot* s, const BundleOptions& options) {
  return adjust_bundle(problem_of(s), options);
}

MapCorrection apply(const AdjustmentSnapshot& s, Map* map) {
  MapCorrection correction = correction_of(s, *map);
  if (!all_in_front(s, correction, *map)) {
    return {};
  }
  for (std::size_t k = 0; k < s.keyframes.size(); ++k) {
    Keyframe& keyframe = map->keyframes[s.keyframes[k].index()];
    if (is_there(s, k, keyframe)) {
      keyframe.pose = transformed(from_inverse_depth(s.poses[k]), correction.back);
    }
  }
  for (std::size_t i = 0; i < s.landmarks.size(); ++i) {
    if (is_there(s, i, *map)) {
      map->landmarks[s.landmarks[i].index()].p_T = correction.back.apply(s.points_T[i]);
    }
  }
  take_along(s, correction, map);
  return correction;
}

}  // namespace polhode
