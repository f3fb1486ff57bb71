#include "motion/stamp_doubt.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "free_body.hpp"

namespace polhode::stamp_doubt_test {
namespace {

constexpr double kTurn_rad = 0.064;    // 3.7 deg a frame
constexpr double kNoise_rad = 0.0005;  // of a pose

/// A body that tumbles on from frame to frame, with stamps of its own; `seconds` is when the
/// pictures were taken.
std::vector<PoseSample> poses(const std::vector<double>& seconds,
                              const std::vector<double>& stamps_s,
                              double rate_rad_s) {
  FreeBody body;
  body.inertia = {1.0, 1.6, 2.1};
  body.w_T_rad_s = rate_rad_s * Eigen::Vector3d(0.3, 0.5, 0.81).normalized();
  std::vector<PoseSample> out;
  Rng rng(7, 1);
  double last = 0.0;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    advance(body, seconds[i] - last);
    last = seconds[i];
    PoseSample sample{.timestamp_ns = static_cast<std::int64_t>(1e9 * stamps_s[i]), .pose = {}};
    const Eigen::Vector3d noise(rng.normal(), rng.normal(), rng.normal());
    sample.pose.R_CT = so3_exp(kNoise_rad * noise) * body.R_CT;
    sample.covariance.setIdentity();
    sample.covariance *= kNoise_rad * kNoise_rad;
    out.push_back(sample);
  }
  return out;
}

std::vector<double> even(std::size_t count, double every_s) {
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(every_s * static_cast<double>(i));
  }
  return out;
}

/// Four pictures 5 ms apart, then a pause.
std::vector<double> bursts(std::size_t count) {
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(0.4 * static_cast<double>(i / 4) + 0.005 * static_cast<double>(i % 4));
  }
  return out;
}

TEST(StampDoubt, StampsOfArrivalAreContradicted_FromTheFirstPauseOn) {
  const auto history = poses(even(40, 0.1), bursts(40), 10.0 * kTurn_rad);
  for (std::size_t count = 6; count <= history.size(); ++count) {
    const StampDoubt doubt = doubt_of_stamps(std::span(history).first(count));
    EXPECT_TRUE(doubt.contradicted) << count;
    EXPECT_NEAR(doubt.shortest_s, 0.005, 1e-6);
    EXPECT_NEAR(doubt.longest_s, 0.385, 1e-6);
  }
  for (std::size_t i = 0; i < history.size(); ++i) {
    EXPECT_TRUE(doubt_of_stamps_about(history, i).contradicted) << i;
  }
}

TEST(StampDoubt, EvenStampsAreNot) {
  const auto history = poses(even(40, 0.1), even(40, 0.1), 10.0 * kTurn_rad);
  EXPECT_FALSE(doubt_of_stamps(history).contradicted);
  EXPECT_FALSE(doubt_of_stamps(std::span(history).first(3)).contradicted);
}

TEST(StampDoubt, TrueBurstsAreNot_TheBodyTurnsInTheirPauses) {
  // 2 deg in a burst's interval, 60 in its pause.
  const auto history = poses(bursts(40), bursts(40), 7.0);
  EXPECT_FALSE(doubt_of_stamps(history).contradicted);
}

TEST(StampDoubt, LostFramesAndAPauseAreNot) {
  std::vector<double> seconds;
  for (int i = 0; i < 60; ++i) {
    if (i % 9 < 7 && (i < 30 || i > 42)) {
      seconds.push_back(0.1 * i);
    }
  }
  const auto history = poses(seconds, seconds, 10.0 * kTurn_rad);
  for (std::size_t i = 0; i < history.size(); ++i) {
    EXPECT_FALSE(doubt_of_stamps_about(history, i).contradicted) << i;
  }
}

TEST(StampDoubt, ABodyThatHardlyTurnsTellsNothing) {
  EXPECT_FALSE(doubt_of_stamps(poses(even(40, 0.1), bursts(40), 0.0)).contradicted);
}

}  // namespace
}  // namespace polhode::stamp_doubt_test
