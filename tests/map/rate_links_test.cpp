#include "map/rate_links.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

#include "geometry/so3.hpp"
#include "solve/bundle_costs.hpp"
#include "synthetic_map.hpp"

namespace polhode::rate_links_test {
namespace {

using namespace synthetic;

std::unique_ptr<AdjustmentSnapshot> linked(const Map& map) {
  auto snapshot = std::make_unique<AdjustmentSnapshot>();
  snapshot_all(map, camera(), snapshot.get());
  add_rate_links(snapshot.get());
  return snapshot;
}

Map& map_of(const std::vector<Pose>& poses, double noise_px, std::uint64_t seed) {
  static SyntheticMap synthetic;
  synthetic = make_map(ball(400, seed), poses, noise_px, seed);
  return *synthetic.map;
}

Eigen::Vector3d residual(const AdjustmentSnapshot& s, const RateLink& link) {
  const ChartedPoses poses(s.poses.view());
  const RateLinkCost cost(link, s.R_IC.view(), poses);
  Eigen::Vector3d r;
  EXPECT_TRUE(cost.Evaluate(nullptr, r.data(), nullptr));
  return r;
}

std::uint32_t number(const AdjustmentSnapshot& s, std::int32_t pose) {
  return s.keyframe_numbers[static_cast<std::size_t>(pose)];
}

TEST(RateLinks, FollowTheKeyframesInTime_ThreeOrFourEach) {
  const auto s = linked(map_of(turn_by(0.05, 6), 0.0, 1));
  ASSERT_EQ(s->motion.links.size(), 4U);
  for (const RateLink& link : s->motion.links) {
    for (std::size_t m = 1; m < link.poses.size(); ++m) {
      EXPECT_EQ(number(*s, link.poses[m]), number(*s, link.poses[m - 1]) + 1);
    }
    EXPECT_EQ(link.poses.size(), number(*s, link.poses.back()) == 2 ? 3U : 4U);
  }
}

TEST(RateLinks, DoNotReachOverATimeInWhichNobodyCountedTheTurns) {
  Map& map = map_of(turn_by(0.05, 8), 0.0, 1);
  for (std::size_t k = 0; k < 4; ++k) {
    map.keyframes[k].timestamp_ns -= 3'600'000'000'000;  // of a pass an hour before
  }
  const auto s = linked(map);
  EXPECT_EQ(s->motion.links.size(), 4U);  // two in each part
  for (const RateLink& link : s->motion.links) {
    const std::uint32_t last = number(*s, link.poses.back());
    EXPECT_TRUE(last < 4 || number(*s, link.poses[0]) >= 4) << last;
  }
}

TEST(RateLinks, AreZeroAtASteadyRate_WhateverTheIntervals) {
  Map& map = map_of({turned(0.0), turned(0.02), turned(0.10), turned(0.13), turned(0.20)}, 0.0, 1);
  const std::array<std::int64_t, 5> steps{0, 2, 10, 13, 20};
  for (std::size_t k = 0; k < steps.size(); ++k) {
    map.keyframes[k].timestamp_ns = 100'000'000 * steps[k];
  }
  const auto s = linked(map);
  ASSERT_EQ(s->motion.links.size(), 3U);
  for (const RateLink& link : s->motion.links) {
    EXPECT_LT(residual(*s, link).norm(), 1e-9);
  }
}

TEST(RateLinks, AreInTheObserversInertialAxes) {
  // The camera turns, and the body stands still.
  Map& map = map_of(turn_by(0.05, 5), 0.0, 1);
  for (std::size_t k = 0; k < 5; ++k) {
    const double angle_rad = 0.01 * static_cast<double>(k * k);
    const Eigen::Matrix3d turn = so3_exp({angle_rad, 0.0, 0.0});
    map.keyframes[k].R_IC = turn;
    map.keyframes[k].pose.R_CT = turn.transpose() * turned(0.05 * static_cast<double>(k)).R_CT;
  }
  const auto s = linked(map);
  ASSERT_EQ(s->motion.links.size(), 3U);
  for (const RateLink& link : s->motion.links) {
    EXPECT_LT(residual(*s, link).norm(), 1e-9);
  }
}

TEST(RateLinks, ReachOverNoLongTurn) {
  EXPECT_TRUE(linked(map_of(turn_by(0.31, 4), 0.0, 1))->motion.links.empty());
  std::vector<Pose> poses = turn_by(0.05, 3);
  for (const double angle_rad : {0.50, 0.55, 0.60}) {
    poses.push_back(turned(angle_rad));
  }
  const auto s = linked(map_of(poses, 0.0, 1));
  ASSERT_EQ(s->motion.links.size(), 2U);
  EXPECT_EQ(s->motion.links[0].poses.size(), 3U);
  EXPECT_EQ(s->motion.links[1].poses.size(), 3U);
}

TEST(RateLinks, HoldNothingThatIsHeld) {
  auto s = std::make_unique<AdjustmentSnapshot>();
  snapshot_all(map_of(turn_by(0.05, 5), 0.0, 1), camera(), s.get());
  for (std::uint8_t& fixed : s->pose_fixed) {
    fixed = 1;
  }
  add_rate_links(s.get());
  EXPECT_TRUE(s->motion.links.empty());
}

/// Attitudes of a body without a torque, by small steps of Euler's equation.
std::vector<Pose> free_body(Rng* rng, double step_rad, int count) {
  const auto moment = [&] { return std::exp(1.5 * rng->normal()); };  // the prior of rigid_model
  const Eigen::Vector3d second(moment(), moment(), moment());
  const Eigen::Vector3d I = Eigen::Vector3d::Constant(second.sum()) - second;
  Eigen::Vector3d w_T = normal3(rng).normalized();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  constexpr int kParts = 200;
  const double dt_s = step_rad / kParts;  // at 1 rad/s
  std::vector<Pose> poses;
  for (int k = 0; k < count * kParts; ++k) {
    if (k % kParts == 0) {
      poses.push_back({.R_CT = R, .p_CT = {0.0, 0.0, kDistance_mu}});
    }
    const Eigen::Vector3d L = I.cwiseProduct(w_T);
    R = R * so3_exp(dt_s * w_T);
    w_T += dt_s * L.cross(w_T).cwiseQuotient(I);
  }
  return poses;
}

TEST(RateLinks, OfFreeBodiesAreOneSigmaFirst_AndLessThen) {
  Rng rng(3, 7);
  double first = 0.0;
  double later = 0.0;
  int firsts = 0;
  int laters = 0;
  for (int body = 0; body < 200; ++body) {
    const auto snapshot = std::make_unique<AdjustmentSnapshot>();
    AdjustmentSnapshot& s = *snapshot;
    for (const Pose& pose : free_body(&rng, 0.05, 6)) {
      const auto k = static_cast<std::uint32_t>(s.poses.size());
      (void)s.keyframes.push_back(KeyframeId::from_index(k));
      (void)s.keyframe_numbers.push_back(k);
      (void)s.poses.push_back(to_inverse_depth(pose));
      (void)s.pose_fixed.push_back(0);
      (void)s.timestamps_ns.push_back(50'000'000 * static_cast<std::int64_t>(k));
      (void)s.R_IC.push_back(Eigen::Matrix3d::Identity());
    }
    add_rate_links(&s);
    for (const RateLink& link : s.motion.links) {
      const bool is_first = link.poses.size() == 3;
      (is_first ? first : later) += residual(s, link).squaredNorm();
      (is_first ? firsts : laters) += 3;
    }
  }
  EXPECT_NEAR(std::sqrt(first / firsts), 1.0, 0.25);  // of 200 bodies, skewed
  EXPECT_LT(std::sqrt(later / laters), 0.5);
}

/// Mean square of the attitudes' errors after an adjustment, T turned so that it is least.
double error2_rad2(const std::vector<Pose>& poses, bool with_links, std::uint64_t seed) {
  auto s = std::make_unique<AdjustmentSnapshot>();
  const Map& map = map_of(poses, kNoise_px, seed);
  snapshot_all(map, camera(), s.get());
  if (with_links) {
    add_rate_links(s.get());
  }
  EXPECT_TRUE(adjust(s.get(), {.iterations_max = 20, .cauchy_sigma = 2.0}).usable);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < poses.size(); ++k) {
    sum += map.keyframes[s->keyframes[k].index()].pose.R_CT.transpose() * s->poses[k].R_CT;
  }
  const Eigen::Matrix3d back = nearest_rotation(sum);
  double error2 = 0.0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double angle_rad = rotation_angle_rad(
        s->poses[k].R_CT, map.keyframes[s->keyframes[k].index()].pose.R_CT * back);
    error2 += angle_rad * angle_rad / static_cast<double>(poses.size());
  }
  return error2;
}

/// Errors with links over those without, RMS of some maps.
double ratio(const std::vector<Pose>& poses) {
  double with = 0.0;
  double without = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    with += error2_rad2(poses, true, seed);
    without += error2_rad2(poses, false, seed);
  }
  return std::sqrt(with / without);
}

TEST(RateLinks, KeepAYoungMapFromBending) { EXPECT_LT(ratio(turn_by(0.05, 10)), 0.8); }

TEST(RateLinks, BearAContact) {
  // The rate is doubled in the middle.
  std::vector<Pose> poses = turn_by(0.04, 5);
  for (int k = 1; k <= 5; ++k) {
    poses.push_back(turned(0.16 + 0.08 * k));
  }
  EXPECT_LT(ratio(poses), 1.1);
}

}  // namespace
}  // namespace polhode::rate_links_test
