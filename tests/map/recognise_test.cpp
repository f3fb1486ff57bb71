// A body that is known, of whose features few look as they did.
#include "map/recognise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "map/blob_agreement.hpp"
#include "seen_frame.hpp"

namespace polhode::recognise_test {
namespace {

using namespace synthetic;

constexpr std::uint64_t kSeed = 5;
constexpr int kSpots = 600;

/// Each blob points along its surface, away from the ball's pole.
void point_blobs(const std::vector<Spot>& body,
                 const Pose& pose,
                 const std::vector<int>& spot_of,
                 Features* features) {
  for (std::size_t i = 0; i < spot_of.size(); ++i) {
    if (spot_of[i] < 0) {
      continue;
    }
    const Spot& spot = body[static_cast<std::size_t>(spot_of[i])];
    const Eigen::Vector3d along = spot.normal_T.cross(Eigen::Vector3d::UnitZ()).normalized();
    const Eigen::Vector2d by = pose.to_camera(spot.p_T + 0.01 * along).hnormalized() -
                               pose.to_camera(spot.p_T).hnormalized();
    (*features)[i].angle_rad = static_cast<float>(std::atan2(by.y(), by.x()));
  }
}

/// Seen from `truth`, with another look on all spots but one in `alike_one_in`.
struct OtherLight : SeenFrame {
  std::vector<Spot> body;
  std::vector<Pose> views;
  std::unique_ptr<LocaliseScratch> scratch = std::make_unique<LocaliseScratch>();
  LocalisedFrame found;

  OtherLight(std::vector<Spot> of, const Pose& truth, int alike_one_in) : body(std::move(of)) {
    for (int i = 0; i < 9; ++i) {
      views.push_back(turned(0.15 * (i - 4)));  // either half as much
    }
    SyntheticMap made = make_map(body, views, 0.3, kSeed);
    Rng rng(kSeed, 151);
    for (std::size_t k = 0; k < views.size(); ++k) {
      Keyframe& keyframe = made.map->keyframes[made.keyframes[k].index()];
      std::vector<int> spots(keyframe.features.size(), -1);
      for (std::size_t spot = 0; spot < made.landmark_of.size(); ++spot) {
        for (std::size_t i = 0; i < spots.size(); ++i) {
          if (made.landmark_of[spot].valid() && keyframe.landmark_of[i] == made.landmark_of[spot]) {
            spots[i] = static_cast<int>(spot);
          }
        }
      }
      point_blobs(body, views[k], spots, &keyframe.features);
    }
    refresh_landmarks(made.map.get(), model);
    state->map = *made.map;
    image = take_image(body, truth, 0.3, 100, &rng);
    point_blobs(body, truth, image.spot_of, image.features.get());
    for (std::size_t i = 0; i < image.spot_of.size(); ++i) {
      if (image.spot_of[i] % alike_one_in != 0) {
        (*image.features)[i].descriptor = random_look(&rng);
      }
    }
  }

  [[nodiscard]] LocaliseInput localise_input() const {
    return {.map = &state->map,
            .features = image.features.get(),
            .camera = &model,
            .options = &localise,
            .seed = 1};
  }
};

Pose rolled(const Pose& pose, double roll_rad, double farther) {
  const Eigen::Matrix3d roll = so3_exp(roll_rad * Eigen::Vector3d::UnitZ());
  return {.R_CT = roll * pose.R_CT, .p_CT = farther * pose.p_CT};
}

/// A long body of two halves that look the same after half a turn in the image.
std::vector<Spot> alike_after_half_a_turn() {
  std::vector<Spot> body = ball(kSpots / 2, kSeed);
  const Eigen::Matrix3d half_turn = so3_exp(std::numbers::pi * Eigen::Vector3d::UnitZ());
  for (std::size_t i = 0; i < kSpots / 2; ++i) {
    body[i].p_T = Eigen::Vector3d(1.4, 1.0, 0.7).cwiseProduct(body[i].p_T);
    const Spot one = body[i];
    body.push_back(
        {.p_T = half_turn * one.p_T, .normal_T = half_turn * one.normal_T, .look = one.look});
  }
  return body;
}

TEST(Recognise, FindsThePose_WhereOneFeatureInSixLooksAsItDid) {
  const Pose truth = rolled(turned(0.4), 1.0, 1.5);
  OtherLight light(ball(kSpots, kSeed), truth, 6);
  const Result<int> agreeing =
      recognise(light.localise_input(), nullptr, light.scratch.get(), &light.found);
  ASSERT_TRUE(agreeing.ok());
  EXPECT_GE(agreeing.value(), kAgreeingBlobsMin);
  EXPECT_LT(rotation_angle_rad(light.found.absolute.pose.R_CT, truth.R_CT), 0.02);
}

TEST(Recognise, FindsNoPose_OfAnotherBody) {
  OtherLight light(ball(kSpots, kSeed), turned(0.4), 6);
  Rng rng(kSeed, 152);
  light.image = take_image(ball(kSpots, kSeed + 1), turned(0.4), 0.3, 100, &rng);
  EXPECT_FALSE(recognise(light.localise_input(), nullptr, light.scratch.get(), &light.found).ok());
}

// Both poses have as many features: whichever was found first is no answer.
TEST(Recognise, FindsNoPose_OfABodyThatLooksTheSameTurnedByHalf) {
  const Pose truth = turned(0.4);
  OtherLight light(alike_after_half_a_turn(), truth, 1);
  EXPECT_FALSE(recognise(light.localise_input(), nullptr, light.scratch.get(), &light.found).ok());
}

TEST(AgreeingBlobs, AreNearlyAllOfARightPose_AndFewWhereBlobsPointAnyWay) {
  const Pose truth = rolled(turned(0.4), 1.0, 1.5);
  OtherLight light(ball(kSpots, kSeed), truth, 1);
  const LocaliseInput input = light.localise_input();
  ASSERT_TRUE(localise_guided(input, truth, 5.0, light.scratch.get(), &light.found).ok());
  const int inliers = light.found.absolute.inliers;
  EXPECT_GE(agreeing_blobs(input, light.found), 3 * inliers / 4);  // a map's normals are rough

  Rng rng(kSeed, 153);
  for (Feature& feature : *light.image.features) {
    feature.angle_rad = static_cast<float>(2.0 * std::numbers::pi * rng.uniform());
  }
  // 20 deg of 180: one in nine, and three sigmas more of 150.
  EXPECT_LE(agreeing_blobs(input, light.found), inliers / 9 + 3 * 12);

  for (Feature& feature : *light.image.features) {
    feature.scale_px *= 2.0F;
  }
  EXPECT_EQ(agreeing_blobs(input, light.found), 0);
}

}  // namespace
}  // namespace polhode::recognise_test
