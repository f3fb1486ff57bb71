#include "map/closure.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "map/map_state.hpp"
#include "map/window.hpp"
#include "synthetic_map.hpp"

namespace polhode::closure_test {
namespace {

using namespace synthetic;

constexpr double kSeen_rad[] = {0.2, 0.32};  // where the side is seen again

/// A side mapped by six keyframes, then long out of sight; it returns in two keyframes whose
/// poses, and the young landmarks made from them, are off by the drift of the turn.
struct Return {
  std::vector<Spot> body = ball(400, 21);
  SyntheticMap mapped = make_map(body, turn_by(0.12, 6), kNoise_px, 21);
  Eigen::Matrix3d drift;
  CameraModel model = camera();
  LocaliseOptions options;
  std::vector<Picture> images;
  std::vector<KeyframeId> back;
  std::unique_ptr<MapScratch> scratch = std::make_unique<MapScratch>();

  Return(double drift_rad, std::uint32_t keyframes_away, const std::vector<Spot>& seen)
      : drift(so3_exp(drift_rad * Eigen::Vector3d(0.6, 0.0, 0.8))) {
    mapped.map->next_keyframe_number += keyframes_away;
    Rng rng(22, 93);
    for (const double angle_rad : kSeen_rad) {
      images.push_back(take_image(seen, turned(angle_rad), kNoise_px, 100, &rng));
      add(images.back(), turned(angle_rad));
    }
    make_young(seen);
    refresh_landmarks(mapped.map.get(), model);
  }

  void add(const Picture& image, const Pose& truth) {
    const KeyframeId id = add_keyframe(mapped.map.get());
    Keyframe& keyframe = mapped.map->keyframes[id.index()];
    keyframe.frame = 100;
    keyframe.pose = {.R_CT = truth.R_CT * drift, .p_CT = truth.p_CT};
    keyframe.features = *image.features;
    back.push_back(id);
  }

  /// Every second spot that both images show became a landmark again.
  void make_young(const std::vector<Spot>& seen) {
    for (std::size_t i = 0; i < images[0].spot_of.size(); ++i) {
      const int spot = images[0].spot_of[i];
      const auto& later = images[1].spot_of;
      const auto found = std::find(later.begin(), later.end(), spot);
      if (spot < 0 || spot % 2 != 0 || found == later.end()) {
        continue;
      }
      const LandmarkId id = add_landmark(mapped.map.get());
      mapped.map->landmarks[id.index()].p_T =
          drift.transpose() * seen[static_cast<std::size_t>(spot)].p_T;
      add_observation(back[0], i, id, mapped.map.get());
      add_observation(
          back[1], static_cast<std::size_t>(found - later.begin()), id, mapped.map.get());
    }
  }

  int close() {
    return close_loop({.map = mapped.map.get(),
                       .features = images[1].features.get(),
                       .camera = &model,
                       .options = &options,
                       .seed = 1,
                       .stream = 7},
                      back[1],
                      {},
                      scratch.get(),
                      mapped.map.get());
  }

  double pose_error_rad() const {
    const Map& map = *mapped.map;
    const Eigen::Matrix3d turn = map.keyframes[back[1].index()].pose.R_CT *
                                 map.keyframes[mapped.keyframes[0].index()].pose.R_CT.transpose();
    return rotation_angle_rad(turn, turned(kSeen_rad[1]).R_CT * turned(0.0).R_CT.transpose());
  }
};

constexpr std::uint32_t kLong = kRecentKeyframes + 10;

// verifies: MAP-05
TEST(CloseLoop, TiesTheNewKeyframeToTheOldLandmarks_AndMergesTheYoung) {
  Return r(0.09, kLong, ball(400, 21));  // 5 deg of drift
  const int young = r.mapped.map->landmark_count;
  const int associated = r.close();
  EXPECT_GT(associated, 60);
  EXPECT_LT(r.mapped.map->landmark_count, young - 20) << "the young have become the old";
  EXPECT_EQ(broken_promise(*r.mapped.map), "");
  int right = 0;
  int wrong = 0;
  const Keyframe& keyframe = r.mapped.map->keyframes[r.back[1].index()];
  for (std::size_t i = 0; i < r.images[1].spot_of.size(); ++i) {
    const int spot = r.images[1].spot_of[i];
    if (!keyframe.landmark_of[i].valid()) {
      continue;
    }
    const bool is_its_own = spot >= 0 && keyframe.landmark_of[i] ==
                                             r.mapped.landmark_of[static_cast<std::size_t>(spot)];
    (is_its_own ? right : wrong) += 1;
  }
  EXPECT_GT(right, 60);
  EXPECT_LT(wrong, right / 10) << "spots that no old landmark stands for keep their young ones";
}

// verifies: MAP-05
TEST(CloseLoop, LeavesAnAdjustmentThatTakesTheDriftAway) {
  Return r(0.09, kLong, ball(400, 21));
  ASSERT_NEAR(r.pose_error_rad(), 0.09, 1e-6);
  ASSERT_GT(r.close(), 0);
  for (const double cauchy_sigma : {100.0, 15.0, 2.0}) {
    const auto taken = std::make_unique<AdjustmentSnapshot>();
    AdjustmentSnapshot& snapshot = *taken;
    snapshot_all(*r.mapped.map, r.model, &snapshot);
    const BundleOptions options{.iterations_max = 30, .cauchy_sigma = cauchy_sigma};
    ASSERT_TRUE(adjust(&snapshot, options).usable);
    (void)apply(snapshot, r.mapped.map.get());
  }
  // 0.5 px at 190 px of radius over a hundred observations: some tenths of a mrad.
  EXPECT_LT(r.pose_error_rad(), 0.003);
}

TEST(CloseLoop, FindsNothing_OnABodyThatIsAnother) {
  Return r(0.0, kLong, ball(400, 23));
  const int before = r.mapped.map->landmark_count;
  EXPECT_EQ(r.close(), 0);
  EXPECT_EQ(r.mapped.map->landmark_count, before);
}

TEST(CloseLoop, FindsNothing_WhereTheAspectWasSeenAMomentAgo) {
  Return r(0.0, 0, ball(400, 21));
  EXPECT_EQ(r.close(), 0);
}

TEST(CloseLoop, RefusesATurnThatDriftCannotExplain) {
  Return r(0.5, kLong, ball(400, 21));  // a four-sided body looks alike after a quarter of a turn
  EXPECT_EQ(r.close(), 0);
}

}  // namespace
}  // namespace polhode::closure_test
