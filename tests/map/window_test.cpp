#include "map/window.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "geometry/alignment.hpp"
#include "geometry/so3.hpp"
#include "synthetic_map.hpp"

namespace polhode::window_test {
namespace {

using namespace synthetic;

constexpr BundleOptions kBundle{.iterations_max = 20, .cauchy_sigma = 2.0};

std::unique_ptr<AdjustmentSnapshot> window_of(const Map& map, int keyframes) {
  auto snapshot = std::make_unique<AdjustmentSnapshot>();
  snapshot_window(map, camera(), keyframes, snapshot.get());
  return snapshot;
}

std::unique_ptr<AdjustmentSnapshot> all_of(const Map& map) {
  auto snapshot = std::make_unique<AdjustmentSnapshot>();
  snapshot_all(map, camera(), snapshot.get());
  return snapshot;
}

int moving(const AdjustmentSnapshot& s) {
  return static_cast<int>(std::count(s.pose_fixed.begin(), s.pose_fixed.end(), std::uint8_t{0}));
}

int fixed(const AdjustmentSnapshot& s) { return static_cast<int>(s.pose_fixed.size()) - moving(s); }

/// RMS distance of the landmarks' images from where they were seen, in pixels.
double rms_px(const Map& map) {
  double sum = 0.0;
  int count = 0;
  for (const Keyframe& keyframe : map.keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      if (keyframe.landmark_of[i].valid()) {
        const Eigen::Vector3d p_C =
            keyframe.pose.to_camera(map.landmarks[keyframe.landmark_of[i].index()].p_T);
        sum += (project_px(camera(), p_C) - project_px(camera(), keyframe.features[i].normalised))
                   .squaredNorm();
        ++count;
      }
    }
  }
  return std::sqrt(sum / count);
}

void disturb(std::uint64_t seed, Map* map) {
  Rng rng(seed, 111);
  for (Landmark& landmark : map->landmarks) {
    landmark.p_T += 0.02 * normal3(&rng);
  }
  for (Keyframe& keyframe : map->keyframes) {
    keyframe.pose.R_CT = so3_exp(0.005 * normal3(&rng)) * keyframe.pose.R_CT;
    keyframe.pose.p_CT +=
        Eigen::Vector3d(0.01 * rng.normal(), 0.01 * rng.normal(), 0.05 * rng.normal());
  }
}

/// The keyframes' mean turn against where they were, and scale and shift of the landmarks, each
/// weighted by its observations.
Similarity drift(const Map& before, const Map& after) {
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < before.keyframes.size(); ++k) {
    if (before.keyframes[k].used) {
      turns += before.keyframes[k].pose.R_CT.transpose() * after.keyframes[k].pose.R_CT;
    }
  }
  std::vector<Eigen::Vector3d> a;
  std::vector<Eigen::Vector3d> b;
  std::vector<double> weights;
  for (std::size_t i = 0; i < before.landmarks.size(); ++i) {
    if (before.landmarks[i].used) {
      a.push_back(after.landmarks[i].p_T);
      b.push_back(before.landmarks[i].p_T);
      weights.push_back(before.landmarks[i].observations);
    }
  }
  return align_rotated(a, b, weights, nearest_rotation(turns)).value();
}

TEST(SnapshotWindow, MovesTheWindow_AndHoldsAtMostTwiceAsManyOthers) {
  const auto s = make_map(ball(300, 21), turn_by(0.1, 12), kNoise_px, 21);
  const auto snapshot_of_map = window_of(*s.map, 3);
  const AdjustmentSnapshot& snapshot = *snapshot_of_map;
  EXPECT_EQ(moving(snapshot), 3);
  EXPECT_GE(fixed(snapshot), 1);
  EXPECT_LE(fixed(snapshot), 6);
  EXPECT_EQ(snapshot.keyframes.size(), snapshot.poses.size());
  EXPECT_EQ(snapshot.landmarks.size(), snapshot.points_T.size());
  EXPECT_EQ(snapshot.points_T.size(), snapshot.point_fixed.size());
  const auto newest =
      std::find(snapshot.keyframes.begin(), snapshot.keyframes.end(), s.keyframes.back());
  ASSERT_NE(newest, snapshot.keyframes.end());
  EXPECT_EQ(snapshot.pose_fixed[static_cast<std::size_t>(newest - snapshot.keyframes.begin())], 0);
}

TEST(SnapshotWindow, HoldsAtLeastOneKeyframe_HoweverLargeTheWindow) {
  const auto s = make_map(ball(200, 22), turn_by(0.1, 4), kNoise_px, 22);
  const auto snapshot_of_map = window_of(*s.map, 30);
  const AdjustmentSnapshot& snapshot = *snapshot_of_map;
  EXPECT_EQ(snapshot.keyframes.size(), 4U);
  EXPECT_GE(fixed(snapshot), 1);
  EXPECT_GE(moving(snapshot), 1);
}

TEST(SnapshotWindow, RefersOnlyToWhatItHolds) {
  const auto s = make_map(ball(300, 23), turn_by(0.1, 12), kNoise_px, 23);
  for (const bool whole : {false, true}) {
    const auto taken = whole ? all_of(*s.map) : window_of(*s.map, 4);
    const AdjustmentSnapshot& snapshot = *taken;
    ASSERT_FALSE(snapshot.observations.empty());
    for (const BundleObservation& o : snapshot.observations) {
      const auto k = static_cast<std::size_t>(o.pose);
      const auto p = static_cast<std::size_t>(o.point);
      ASSERT_LT(k, snapshot.keyframes.size());
      ASSERT_LT(p, snapshot.landmarks.size());
      EXPECT_GT(o.sigma_normalised, 0.0);
      const auto& associations = s.map->keyframes[snapshot.keyframes[k].index()].landmark_of;
      EXPECT_NE(std::find(associations.begin(), associations.end(), snapshot.landmarks[p]),
                associations.end());
    }
  }
}

TEST(SnapshotAll, HasEveryKeyframeAndEveryLandmark_WithItsObservations) {
  const auto s = make_map(ball(300, 24), turn_by(0.1, 8), kNoise_px, 24);
  const auto snapshot_of_map = all_of(*s.map);
  const AdjustmentSnapshot& snapshot = *snapshot_of_map;
  EXPECT_EQ(snapshot.keyframes.size(), 8U);
  EXPECT_EQ(static_cast<int>(snapshot.landmarks.size()), s.map->landmark_count);
  int observations = 0;
  for (const Landmark& landmark : s.map->landmarks) {
    observations += landmark.used ? landmark.observations : 0;
  }
  EXPECT_EQ(static_cast<int>(snapshot.observations.size()), observations);
  EXPECT_GE(fixed(snapshot), 1);
}

TEST(SnapshotAll, LeavesOutTheOldestObservations_WhenTheTableIsFull_AndTheRestIsAdjusted) {
  const auto s = make_map(ball(2600, 29), turn_by(0.06, limits::kKeyframes), kNoise_px, 29);
  const auto all_of_map = all_of(*s.map);
  AdjustmentSnapshot& all = *all_of_map;
  ASSERT_TRUE(all.observations.full());
  ASSERT_GT(all.left_out, 1000U);
  std::vector<int> of_pose(all.poses.size(), 0);
  for (const BundleObservation& o : all.observations) {
    ++of_pose[static_cast<std::size_t>(o.pose)];
  }
  EXPECT_GT(of_pose.front(), 0) << "the newest keyframe";
  EXPECT_EQ(of_pose.back(), 0) << "the oldest one";
  ASSERT_TRUE(adjust(&all, {.iterations_max = 3, .cauchy_sigma = 2.0}).usable);
  (void)apply(all, s.map.get());
  // Where nothing is seen nothing moves, but by what brings all of the map back to its place.
  EXPECT_LT(rms_px(*s.map), 1.1 * 0.71);
  EXPECT_EQ(broken_promise(*s.map), "");
}

TEST(Snapshots, AreEmpty_WhenTheMapIs) {
  const auto map = std::make_unique<Map>();
  EXPECT_TRUE(window_of(*map, 5)->keyframes.empty());
  const auto all_of_map = all_of(*map);
  AdjustmentSnapshot& all = *all_of_map;
  EXPECT_TRUE(all.keyframes.empty());
  EXPECT_FALSE(adjust(&all, kBundle).usable);
}

TEST(Adjust, BringsAJoltedMapBackToItsNoise) {
  const auto s = make_map(ball(300, 25), turn_by(0.15, 8), kNoise_px, 25);
  disturb(25, s.map.get());
  const double before_px = rms_px(*s.map);
  ASSERT_GT(before_px, 3.0);
  const auto all_of_map = all_of(*s.map);
  AdjustmentSnapshot& all = *all_of_map;
  ASSERT_TRUE(adjust(&all, kBundle).usable);
  (void)apply(all, s.map.get());
  // Two coordinates of 0.5 px each are 0.71 px RMS; the fit takes some of it away.
  EXPECT_LT(rms_px(*s.map), 1.1 * 0.71);
  EXPECT_EQ(broken_promise(*s.map), "");
}

TEST(Adjust, OfAWindow_LowersTheErrorOfTheMap) {
  const auto s = make_map(ball(300, 26), turn_by(0.1, 12), kNoise_px, 26);
  Rng rng(26, 112);
  Keyframe& newest = s.map->keyframes[s.keyframes.back().index()];
  newest.pose.R_CT = so3_exp(0.02 * normal3(&rng)) * newest.pose.R_CT;
  const double before_px = rms_px(*s.map);
  const auto window_of_map = window_of(*s.map, 4);
  AdjustmentSnapshot& window = *window_of_map;
  ASSERT_TRUE(adjust(&window, kBundle).usable);
  (void)apply(window, s.map.get());
  EXPECT_LT(rms_px(*s.map), before_px);
  EXPECT_LT(rms_px(*s.map), 1.2 * 0.71);
}

TEST(Adjust, OfAWindow_DoesNotMoveWhatIsHeld) {
  const auto s = make_map(ball(300, 27), turn_by(0.1, 12), kNoise_px, 27);
  disturb(27, s.map.get());
  const auto before = std::make_unique<Map>(*s.map);
  const auto window_of_map = window_of(*s.map, 3);
  AdjustmentSnapshot& window = *window_of_map;
  ASSERT_GE(fixed(window), 2);
  ASSERT_TRUE(adjust(&window, kBundle).usable);
  (void)apply(window, s.map.get());
  std::vector<bool> moved(limits::kKeyframes, false);
  for (std::size_t k = 0; k < window.keyframes.size(); ++k) {
    moved[window.keyframes[k].index()] = window.pose_fixed[k] == 0;
  }
  for (const KeyframeId id : s.keyframes) {
    if (!moved[id.index()]) {
      const Pose& was = before->keyframes[id.index()].pose;
      const Pose& is = s.map->keyframes[id.index()].pose;
      EXPECT_LT((is.R_CT - was.R_CT).norm() + (is.p_CT - was.p_CT).norm(), 1e-12) << "to rounding";
    }
  }
}

TEST(Apply, KeepsAxesOriginAndScale_WhenAllMoved) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const auto s = make_map(ball(300, 28), turn_by(0.15, 8), kNoise_px, seed);
    disturb(seed, s.map.get());
    const auto before = std::make_unique<Map>(*s.map);
    const auto all_of_map = all_of(*s.map);
    AdjustmentSnapshot& all = *all_of_map;
    ASSERT_TRUE(adjust(&all, kBundle).usable);
    (void)apply(all, s.map.get());
    const Similarity moved = drift(*before, *s.map);
    // The map was brought back by this very fit: what is left of it is rounding.
    EXPECT_NEAR(moved.scale, 1.0, 1e-9);
    EXPECT_LT(rotation_angle_rad(moved.R_ba, Eigen::Matrix3d::Identity()), 1e-7);
    EXPECT_LT(moved.t_ba.norm(), 1e-9);
  }
}

TEST(Apply, IsNotCarriedAway_ByALandmarkThatRanAway) {
  const auto s = make_map(ball(300, 28), turn_by(0.15, 8), kNoise_px, 4);
  const auto before = std::make_unique<Map>(*s.map);
  const auto all = all_of(*s.map);
  ASSERT_TRUE(adjust(all.get(), kBundle).usable);
  all->points_T[17] *= 1e5;
  (void)apply(*all, s.map.get());
  for (const Keyframe& keyframe : s.map->keyframes) {
    if (keyframe.used) {
      const Pose& was =
          before->keyframes[static_cast<std::size_t>(&keyframe - s.map->keyframes.data())].pose;
      EXPECT_LT((keyframe.pose.p_CT - was.p_CT).norm(), 0.01 * was.p_CT.norm());
    }
  }
}

/// A window's snapshot whose newest keyframe the solution has moved, and the map that has grown by
/// a keyframe and a landmark since.
struct GrownSince {
  explicit GrownSince(std::uint64_t seed)
      : synthetic(make_map(ball(300, 30), turn_by(0.1, 12), kNoise_px, seed)),
        snapshot(window_of(*synthetic.map, 4)) {
    Map& map = *synthetic.map;
    Rng rng(seed, 114);
    before = map.keyframes[snapshot->keyframes[0].index()].pose;
    Pose solved = before;
    solved.R_CT = so3_exp(0.02 * normal3(&rng)) * solved.R_CT;
    solved.p_CT += 0.05 * normal3(&rng);
    snapshot->poses[0] = to_inverse_depth(solved);
    keyframe = add_keyframe(&map);
    map.keyframes[keyframe.index()].pose = {.R_CT = so3_exp({0.0, 0.1, 0.0}) * before.R_CT,
                                            .p_CT = before.p_CT};
    landmark = add_landmark(&map);
    map.landmarks[landmark.index()].p_T = normal3(&rng);
  }
  [[nodiscard]] Map& map() const { return *synthetic.map; }

  SyntheticMap synthetic;
  std::unique_ptr<AdjustmentSnapshot> snapshot;
  Pose before;  ///< of the snapshot's newest keyframe
  KeyframeId keyframe;
  LandmarkId landmark;
};

TEST(Apply, ChangesNothing_WhereTheBodyWouldLieBehindACamera) {
  const GrownSince g(2);
  const auto before = std::make_unique<Map>(g.map());
  // The newest keyframe comes so much nearer that the one that came since would be beyond the body.
  g.map().keyframes[g.keyframe.index()].pose.p_CT = 0.1 * g.before.p_CT;
  Pose near = g.before;
  near.p_CT *= 0.2;
  g.snapshot->poses[0] = to_inverse_depth(near);
  const MapCorrection correction = apply(*g.snapshot, &g.map());
  EXPECT_EQ(correction.timestamp_ns, INT64_MAX);
  const std::size_t newest = g.snapshot->keyframes[0].index();
  EXPECT_EQ(g.map().keyframes[newest].pose.p_CT, before->keyframes[newest].pose.p_CT);
  EXPECT_EQ(g.map().keyframes[g.keyframe.index()].pose.p_CT, 0.1 * g.before.p_CT);
}

TEST(Apply, WhatHasComeSinceKeepsItsPlaceBesideTheNewestKeyframe) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const GrownSince g(seed);
    const Pose young_before = g.map().keyframes[g.keyframe.index()].pose;
    const Eigen::Vector3d p_before = g.map().landmarks[g.landmark.index()].p_T;
    const MapCorrection correction = apply(*g.snapshot, &g.map());
    const Pose& after = g.map().keyframes[g.snapshot->keyframes[0].index()].pose;
    ASSERT_GT((after.R_CT - g.before.R_CT).norm(), 1e-3);
    // The point stands before both cameras as it did, and so does one camera before the other.
    const Pose& young = g.map().keyframes[g.keyframe.index()].pose;
    const Eigen::Vector3d p = g.map().landmarks[g.landmark.index()].p_T;
    EXPECT_LT((after.to_camera(p) - g.before.to_camera(p_before)).norm(), 1e-12);
    EXPECT_LT((young.to_camera(p) - young_before.to_camera(p_before)).norm(), 1e-12);
    const Pose moved = correction.moved(young_before);
    EXPECT_LT((moved.R_CT - young.R_CT).norm() + (moved.p_CT - young.p_CT).norm(), 1e-12);
  }
}

TEST(Apply, LeavesAloneWhatHasTakenAFreedPlaceSince) {
  const GrownSince g(7);
  const LandmarkId left = g.snapshot->landmarks[3];
  remove_landmark(left, &g.map());
  const LandmarkId came = add_landmark(&g.map());
  ASSERT_EQ(came, left);
  const Eigen::Vector3d p_T(3.0, 2.0, 1.0);
  g.map().landmarks[came.index()].p_T = p_T;
  const MapCorrection correction = apply(*g.snapshot, &g.map());
  EXPECT_LT((g.map().landmarks[came.index()].p_T - correction.moved_point(p_T)).norm(), 1e-12);
}

TEST(Apply, GivesBackTheSameMap_WhenTheSolutionDiffersByASimilarity) {
  const auto s = make_map(ball(200, 29), turn_by(0.15, 6), kNoise_px, 29);
  const auto before = std::make_unique<Map>(*s.map);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Rng rng(seed, 113);
    const double c = 0.5 + rng.uniform();
    const Eigen::Matrix3d Q = so3_exp(normal3(&rng));
    const Eigen::Vector3d q = normal3(&rng);
    const auto all_of_map = all_of(*s.map);
    AdjustmentSnapshot& all = *all_of_map;
    for (Eigen::Vector3d& p : all.points_T) {
      p = c * Q * p + q;
    }
    for (InverseDepthPose& pose : all.poses) {
      // p_C' = c p_C for p' = c Q p + q: all images stay.
      const Pose old = from_inverse_depth(pose);
      const Eigen::Matrix3d R = old.R_CT * Q.transpose();
      pose = to_inverse_depth({.R_CT = R, .p_CT = c * old.p_CT - R * q});
    }
    (void)apply(all, s.map.get());
    for (std::size_t i = 0; i < before->landmarks.size(); ++i) {
      if (before->landmarks[i].used) {
        EXPECT_LT((s.map->landmarks[i].p_T - before->landmarks[i].p_T).norm(), 1e-9);
      }
    }
    for (const KeyframeId id : s.keyframes) {
      const Pose& was = before->keyframes[id.index()].pose;
      const Pose& is = s.map->keyframes[id.index()].pose;
      EXPECT_LT((is.R_CT - was.R_CT).norm() + (is.p_CT - was.p_CT).norm(), 1e-9);
    }
  }
}

TEST(Apply, KeepsT_WhenScaleAndOriginRanAway_AndSomeLandmarks) {
  for (const double scale : {0.02, 0.5, 1.0, 2.0, 40.0}) {
    SyntheticMap synthetic = make_map(ball(300, 3), turn_by(0.1, 10), kNoise_px, 3);
    Map& map = *synthetic.map;
    const auto before = std::make_unique<Map>(map);
    const auto s = all_of(map);
    const Similarity away{.scale = scale, .t_ba = scale * Eigen::Vector3d(0.3, -2.0, 4.0)};
    for (InverseDepthPose& pose : s->poses) {
      pose = to_inverse_depth(transformed(from_inverse_depth(pose), away));
    }
    for (std::size_t i = 0; i < s->points_T.size(); ++i) {
      s->points_T[i] = away.apply((i % 50 == 7 ? 30.0 : 1.0) * s->points_T[i]);
    }
    const MapCorrection correction = apply(*s, &map);
    EXPECT_NEAR(correction.back.scale, 1.0 / scale, 1e-6 / scale);
    for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
      if (map.keyframes[k].used) {
        EXPECT_LT((map.keyframes[k].pose.p_CT - before->keyframes[k].pose.p_CT).norm(), 1e-6)
            << scale;
      }
    }
  }
}

}  // namespace
}  // namespace polhode::window_test
