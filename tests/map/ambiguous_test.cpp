// A body with alike faces, looked at again without a motion that indicates which one it is.
#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "seen_frame.hpp"

namespace polhode::ambiguous_test {
namespace {

using namespace synthetic;

constexpr std::size_t kFaceSpots = 160;
constexpr double kWrong_rad = 0.1;  // 6 deg. A right pose is off by a tenth of it

/// A cap of spots that faces the camera, and the same once more on the other side.
std::vector<Spot> two_faces(std::uint64_t seed) {
  Rng rng(seed, 141);
  std::vector<Spot> body;
  while (body.size() < kFaceSpots) {
    const Eigen::Vector3d n = normal3(&rng).normalized();
    if (n.z() < -0.6) {
      body.push_back({.p_T = n, .normal_T = n, .look = random_look(&rng)});
    }
  }
  const Eigen::Matrix3d half_turn = so3_exp(std::numbers::pi * Eigen::Vector3d::UnitY());
  for (std::size_t i = 0; i < kFaceSpots; ++i) {
    const Spot& front = body[i];
    body.push_back(
        {.p_T = half_turn * front.p_T, .normal_T = half_turn * front.normal_T, .look = front.look});
  }
  return body;
}

std::vector<Pose> views_of_both_faces() {
  std::vector<Pose> views;
  for (const double side_rad : {0.0, std::numbers::pi}) {
    for (int i = 0; i < 5; ++i) {
      views.push_back(turned(side_rad - 0.24 + 0.12 * i));
    }
  }
  return views;
}

struct Look : SeenFrame {
  bool found = false;
  double error_rad = 0.0;

  /// Relocalised from `truth`. @param mapped_spots  the first ones.
  Look(const std::vector<Spot>& body,
       const std::vector<Pose>& views,
       std::size_t mapped_spots,
       const Pose& truth,
       std::uint64_t seed) {
    state->map = *make_map(body, views, kNoise_px, seed, mapped_spots).map;
    Rng rng(seed, 142);
    image = take_image(body, truth, kNoise_px, 40, &rng);
    found = relocalise_frame(input(), state.get());
    error_rad = found ? rotation_angle_rad(state->localised.absolute.pose.R_CT, truth.R_CT) : 0.0;
  }

  [[nodiscard]] bool ambiguous(const std::optional<ExpectedPose>& expected = std::nullopt) const {
    return is_ambiguous(input(), expected, state.get());
  }
};

// The face that is seen is mapped by half. What is not mapped of it looks like the other face
// alone.
TEST(IsAmbiguous, IsTrue_WhereTheWrongOneOfTwoAlikeFacesIsFound) {
  int wrong = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Look look(two_faces(seed),
                    views_of_both_faces(),
                    kFaceSpots + kFaceSpots / 2,
                    turned(std::numbers::pi + 0.05),
                    seed);
    if (look.found && look.error_rad > kWrong_rad) {
      ++wrong;
      EXPECT_TRUE(look.ambiguous()) << seed;
    }
  }
  EXPECT_GE(wrong, 5) << "else nothing was tried";
}

TEST(IsAmbiguous, IsFalse_WhereAMotionThatWasCheckedBearsThePoseOut) {
  const Pose truth = turned(0.05);
  const Look look(two_faces(2), views_of_both_faces(), kFaceSpots + kFaceSpots / 2, truth, 2);
  ASSERT_TRUE(look.found);
  ExpectedPose expected;
  expected.prediction.pose = truth;
  expected.prediction.covariance = 1e-4 * PoseCovariance::Identity();
  expected.prediction.rotation_poses = expected.prediction.position_poses = 20;
  expected.poses_since_start = 20;
  expected.step_rad = 0.05;
  EXPECT_TRUE(look.ambiguous());
  EXPECT_FALSE(look.ambiguous(expected));
  expected.prediction.rotation_poses = 2;  // two poses give a motion that nothing has checked
  EXPECT_TRUE(look.ambiguous(expected));
}

TEST(IsAmbiguous, IsFalse_OnABodyWithoutAlikeFaces_AndLeavesThePoseAsItIs) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Look look(
        ball(400, seed), turn_by(0.2, 31), 1000, turned(0.3 * static_cast<double>(seed)), seed);
    if (look.found) {
      ++found;
      const LocalisedFrame before = look.state->localised;
      EXPECT_FALSE(look.ambiguous()) << seed;
      EXPECT_LT(look.error_rad, kWrong_rad) << seed;
      EXPECT_EQ(look.state->localised.absolute.pose.R_CT, before.absolute.pose.R_CT);
      EXPECT_EQ(look.state->localised.matches.size(), before.matches.size());
    }
  }
  EXPECT_GE(found, 18);
}

}  // namespace
}  // namespace polhode::ambiguous_test
