// A body that is out of sight for a quarter of a turn shows a side that no keyframe has seen: the
// map begins anew, in the same T.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>

#include "bench.hpp"
#include "bus/event_table.hpp"
#include "geometry/so3.hpp"
#include "packets_of.hpp"

namespace polhode::restart_test {
namespace {

using namespace bench;

constexpr int kGone = 20;  // first frame out of sight
constexpr int kBack = 52;  // 128 deg later
constexpr int kFrames = 76;

struct Passage {
  std::vector<MotionState> motion;
  std::vector<std::uint8_t> bytes;
  std::vector<bus::EventPacket> events;
  Counters counters;

  [[nodiscard]] std::ptrdiff_t told(bus::EventId id) const {
    return std::count_if(events.begin(), events.end(), [&](const bus::EventPacket& e) {
      return e.id == static_cast<std::uint16_t>(id);
    });
  }
};

/// @param away_s  time out of sight beside that of the frames.
/// @param back    which way the body turns once it is back.
Passage run(int away_s = 0, int back = 1) {
  const Ball ball(3);
  Bench b;
  Passage r;
  for (int i = 0; i < kFrames; ++i) {
    const bool seen = i < kGone || i >= kBack;
    b.time_s += i == kBack ? away_s : 0;
    const StepOutput& out =
        seen ? b.show(ball.seen_from(turning(i < kBack ? i : kBack + back * (i - kBack))))
             : b.component->step({.frame = unreadable(++b.time_s * Bench::kSecond_ns)});
    r.motion.push_back(out.motion);
    r.bytes.insert(r.bytes.end(), out.packets.begin(), out.packets.end());
    for (const bus::EventPacket& event : packets_of<bus::EventPacket>(out))
      r.events.push_back(event);
  }
  r.counters = b.component->counters();
  return r;
}

const Passage& passage() {
  static const Passage r = run();
  return r;
}

int first_pose(int from) {
  int i = from;
  while (i < kFrames && !is_measured(passage().motion[static_cast<std::size_t>(i)])) {
    ++i;
  }
  return i;
}

TEST(Restart, FollowsTheSideThatCameInTheDark) {
  const int again = first_pose(kGone);
  ASSERT_GE(again, kBack);
  ASSERT_LT(again, kFrames - 8) << "a start takes half a radian of turn";
  EXPECT_EQ(passage().counters.restarts, 1U);
  EXPECT_EQ(passage().counters.lost, 1U);
  for (int i = again; i < kFrames; ++i) {
    EXPECT_TRUE(passage().motion[static_cast<std::size_t>(i)].pose_valid) << i;
  }
}

TEST(Restart, StaysInTheSameT_AsFarAsTheMotionBeforeTellsIt) {
  const int before = first_pose(0);
  const int after = first_pose(kGone);
  ASSERT_LT(after, kFrames);
  const MotionState& a = passage().motion[static_cast<std::size_t>(before)];
  const MotionState& b = passage().motion[static_cast<std::size_t>(after)];
  const double error_rad =
      rotation_angle_rad(rotation_of(b) * rotation_of(a).transpose(),
                         turning(after).R_CT * turning(before).R_CT.transpose());
  EXPECT_LT(error_rad, 3.0 * b.sigma_att_rad);
  EXPECT_GT(b.sigma_att_rad, 2.0 * a.sigma_att_rad) << "the gap is part of the sigma";
  EXPECT_LT(b.sigma_att_rad, 0.35) << "20 deg: more would say nothing";
}

Eigen::Vector3d position_of(const MotionState& m) { return {m.p_CT[0], m.p_CT[1], m.p_CT[2]}; }

TEST(Restart, KeepsOriginAndUnit_AsFarAsTheBodyTellsThem) {
  // The ball's centre stands still: unit k and centre c_T in the map's T with k p_C - R_CT c_T =
  // p_CT, from the frames before.
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (int i = first_pose(0); i < kGone; ++i) {
    const MotionState& m = passage().motion[static_cast<std::size_t>(i)];
    Eigen::Matrix<double, 3, 4> row;
    row << turning(i).p_CT, -rotation_of(m);
    normal += row.transpose() * row;
    right += row.transpose() * position_of(m);
  }
  const Eigen::Vector4d found = normal.ldlt().solve(right);
  const int after = first_pose(kGone);
  ASSERT_LT(after, kFrames);
  const MotionState& m = passage().motion[static_cast<std::size_t>(after)];
  const Eigen::Vector3d expected =
      found(0) * turning(after).p_CT - rotation_of(m) * found.tail<3>();
  EXPECT_LT((position_of(m) - expected).norm(), 3.0 * m.sigma_pos);
  EXPECT_LT((position_of(m) - expected).norm(), 0.3 * expected.norm());
}

// verifies: MAP-09
TEST(Restart, InTheSameTIsToldAsFoundAgain) {
  EXPECT_EQ(passage().told(bus::EventId::kTargetFoundAgain), 1);
  EXPECT_EQ(passage().told(bus::EventId::kTargetFrameNew), 0);
}

// verifies: MAP-09
TEST(Restart, InAnotherTIsToldAsThat) {
  // After a week nothing is known of how far the body has turned.
  const Passage r = run(7 * 86400);
  ASSERT_EQ(r.counters.restarts, 1U);
  EXPECT_EQ(r.told(bus::EventId::kTargetFoundAgain), 0);
  EXPECT_EQ(r.told(bus::EventId::kTargetFrameNew), 1);
  const auto told = std::find_if(r.events.begin(), r.events.end(), [](const bus::EventPacket& e) {
    return e.id == static_cast<std::uint16_t>(bus::EventId::kTargetFrameNew);
  });
  EXPECT_EQ(told->value[1], 2.0) << "the number of the frame";
}

TEST(Restart, ThatContradictsTheMotionBeforeIsInAnotherT) {
  const Passage r = run(0, -1);
  ASSERT_EQ(r.counters.restarts, 1U);
  EXPECT_EQ(r.told(bus::EventId::kTargetFoundAgain), 0);
  EXPECT_EQ(r.told(bus::EventId::kTargetFrameNew), 1);
}

TEST(Restart, GivesTheSameBytes) { EXPECT_EQ(run().bytes, passage().bytes); }

}  // namespace
}  // namespace polhode::restart_test
