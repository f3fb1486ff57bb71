// A camera that turns itself: rates are those relative to inertial space, however the servicer's
// attitude comes in.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "../bus/command_packets.hpp"
#include "bench.hpp"
#include "geometry/so3.hpp"

namespace polhode::observer_test {
namespace {

using namespace bench;

constexpr int kFrames = 20;
const Eigen::Vector3d kCameraRate_C{0.0, 0.01, -0.02};  // rad/s

const std::vector<Picture>& pictures() {
  static const std::vector<Picture> rendered = images_of_turning(kFrames);
  return rendered;
}

Eigen::Quaterniond attitude_IC(std::int64_t time_s) {
  return Eigen::Quaterniond(so3_exp(static_cast<double>(time_s) * kCameraRate_C));
}

MotionState last_state(bool by_input, bool by_command, int told_at = 0) {
  Bench b;
  MotionState last;
  for (int i = 0; i < kFrames; ++i) {
    StepInput input{
        .frame = frame_of(++b.time_s * Bench::kSecond_ns, pictures()[static_cast<std::size_t>(i)])};
    const Eigen::Quaterniond q = attitude_IC(b.time_s);
    if (by_input) {
      input.q_IC = {q.w(), q.x(), q.y(), q.z()};
    }
    bus::CommandOctets octets;
    std::span<const std::uint8_t> one;
    if (by_command && i == told_at) {
      octets =
          bus::command(bus::CommandCode::kServicerAttitude,
                       bus::ServicerAttitudeCommand{
                           .timestamp_ns = b.time_s * Bench::kSecond_ns,
                           .q_IC = {q.w(), q.x(), q.y(), q.z()},
                           .w_C_rad_s = {kCameraRate_C.x(), kCameraRate_C.y(), kCameraRate_C.z()}});
      one = octets;
      input.commands = {&one, 1};
    }
    last = b.component->step(input).motion;
  }
  return last;
}

Eigen::Vector3d rate(const MotionState& m) { return Eigen::Vector3d(m.w_T_rad_s.data()); }

TEST(Observer, ThatTurns_AddsItsRateToTheOneSeen) {
  const MotionState still = last_state(false, false);
  const MotionState turning = last_state(true, false);
  ASSERT_TRUE(still.rate_valid && turning.rate_valid);
  const Eigen::Quaterniond q_CT(turning.q_CT[0], turning.q_CT[1], turning.q_CT[2], turning.q_CT[3]);
  const Eigen::Vector3d expected = rate(still) + q_CT.conjugate() * kCameraRate_C;
  // Both are estimates from the same pictures: they differ by how each fit weighs their noise.
  EXPECT_LT((rate(turning) - expected).norm(), 0.1 * kCameraRate_C.norm());
  // Tracking searches where another path is expected, so the same pictures give other inliers; the
  // attitude stays within what the map's first frames tell apart (2 deg on this ball).
  const Eigen::Quaterniond q_still(still.q_CT[0], still.q_CT[1], still.q_CT[2], still.q_CT[3]);
  EXPECT_LT(q_still.angularDistance(q_CT), 0.035);
}

TEST(Observer, ToldByCommand_IsTheOneToldWithEachFrame) {
  const MotionState by_input = last_state(true, false);
  const MotionState by_command = last_state(false, true);
  EXPECT_LT((rate(by_input) - rate(by_command)).norm(), 1e-9);
}

TEST(Observer, ToldBothWays_IsCountedOnce) {
  const MotionState once = last_state(true, false);
  const MotionState twice = last_state(true, true);
  EXPECT_EQ(once.w_T_rad_s, twice.w_T_rad_s);
  EXPECT_EQ(once.v_C, twice.v_C);
}

}  // namespace
}  // namespace polhode::observer_test
