// What a pose that was found in a picture is held against.
#include "pipeline/track.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"
#include "geometry/so3.hpp"
#include "pipeline/motion_jobs.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

using namespace bench;

constexpr double kStep_rad = 0.17;

Pose pose_at(int second) {
  return {.R_CT = so3_exp(kStep_rad * second * Eigen::Vector3d::UnitY()), .p_CT = {0.0, 0.0, 8.0}};
}

const PoseCovariance kCovariance = 1e-6 * PoseCovariance::Identity();

/// Is a pose taken that is off the motion so far by an angle?
bool takes(double off_rad, int second, Component::State* s, bool start_checks = false) {
  const PosePrediction predicted = predict_or_hold(s->motion,
                                                   s->drift,
                                                   s->parameters.motion,
                                                   second * Bench::kSecond_ns,
                                                   Eigen::Matrix3d::Identity())
                                       .value();
  s->localised.absolute.pose = predicted.pose;
  s->localised.absolute.pose.R_CT =
      so3_exp(off_rad * Eigen::Vector3d::UnitX()) * predicted.pose.R_CT;
  s->localised.absolute.covariance = kCovariance;
  return plausible(predicted, start_checks, *s);
}

/// The motion of a start of six frames.
void start(Component::State* s) {
  StartPoses poses;
  for (int second = 1; second <= 6; ++second) {
    (void)poses.push_back({.timestamp_ns = second * Bench::kSecond_ns,
                           .pose = pose_at(second),
                           .covariance = kCovariance});
  }
  restate_motion(poses.view(), s);
}

TEST(Plausible, AMotionIsYoung_UntilPosesOtherThanItsStartsHaveBorneItOut) {
  constexpr double kOff_rad =
      0.04;  // 5 sigma and a twentieth of a step are less, a step's square and a degree are more
  Bench b(parameters());
  Component::State& s = b.component->state();
  start(&s);
  EXPECT_TRUE(takes(kOff_rad, 7, &s));
  EXPECT_FALSE(takes(kOff_rad, 7, &s, true));
  EXPECT_FALSE(takes(3.0 * kOff_rad, 7, &s));
  for (int second = 7; second <= 12; ++second) {
    EXPECT_TRUE(takes(kOff_rad, second, &s)) << second;
    remember_motion(second * Bench::kSecond_ns, pose_at(second), kCovariance, &s);
  }
  EXPECT_FALSE(takes(kOff_rad, 13, &s));
  start(&s);  // after a loss
  EXPECT_TRUE(takes(kOff_rad, 13, &s));
}

}  // namespace
}  // namespace polhode
