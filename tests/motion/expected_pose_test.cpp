// What a pose that was found in a picture is held against.
#include <gtest/gtest.h>

#include <memory>

#include "geometry/so3.hpp"
#include "map/track.hpp"
#include "motion/estimator.hpp"

namespace polhode::expected_pose_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kStep_rad = 0.17;

Pose pose_at(int second) {
  return {.R_CT = so3_exp(kStep_rad * second * Eigen::Vector3d::UnitY()), .p_CT = {0.0, 0.0, 8.0}};
}

const PoseCovariance kCovariance = 1e-6 * PoseCovariance::Identity();

/// A motion, and the map that poses are found in.
struct Followed {
  MotionOptions options;
  MotionEstimate motion;
  std::unique_ptr<MapState> mapping = std::make_unique<MapState>();

  /// Is a pose taken that is off the motion so far by an angle?
  bool takes(double off_rad, int second, bool initialisation_checks = false) {
    const PosePrediction predicted =
        predict_or_hold(
            motion, mapping->drift, options, second * kSecond_ns, Eigen::Matrix3d::Identity())
            .value();
    AbsolutePose& found = mapping->localised.absolute;
    found.pose = predicted.pose;
    found.pose.R_CT = so3_exp(off_rad * Eigen::Vector3d::UnitX()) * predicted.pose.R_CT;
    found.covariance = kCovariance;
    return plausible(
        expected_at(predicted, second * kSecond_ns, motion), initialisation_checks, *mapping);
  }

  /// The motion of a start of six frames.
  void start() {
    FixedVector<PoseSample, 6> poses;
    for (int second = 1; second <= 6; ++second) {
      (void)poses.push_back({.timestamp_ns = second * kSecond_ns,
                             .pose = pose_at(second),
                             .covariance = kCovariance});
    }
    restate_poses(poses.view(), &motion);
  }
};

TEST(Plausible, AMotionIsYoung_UntilPosesOtherThanItsStartsHaveConfirmedIt) {
  // 5 sigma and a twentieth of a step are less; a step's square and a degree are more.
  constexpr double kOff_rad = 0.04;
  Followed f;
  f.start();
  EXPECT_TRUE(f.takes(kOff_rad, 7));
  EXPECT_FALSE(f.takes(kOff_rad, 7, true));
  EXPECT_FALSE(f.takes(3.0 * kOff_rad, 7));
  for (int second = 7; second <= 12; ++second) {
    EXPECT_TRUE(f.takes(kOff_rad, second)) << second;
    (void)remember_pose(second * kSecond_ns, pose_at(second), kCovariance, f.options, &f.motion);
  }
  EXPECT_FALSE(f.takes(kOff_rad, 13));
  f.start();  // after a loss
  EXPECT_TRUE(f.takes(kOff_rad, 13));
}

TEST(Plausible, AMapThatHasMovedUnderItsPosesAllowsForAsMuch) {
  constexpr double kOff_rad = 0.3;
  Followed f;
  f.start();
  EXPECT_FALSE(f.takes(kOff_rad, 7));
  f.mapping->moved_rad = kOff_rad;
  EXPECT_TRUE(f.takes(kOff_rad, 7));
}

}  // namespace
}  // namespace polhode::expected_pose_test
