// A planner asks where a point of the target will be, and is answered by call and by packet alike.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "bus/packet_layout.hpp"
#include "commanded.hpp"
#include "geometry/so3.hpp"

namespace polhode::point_question_test {
namespace {

using namespace bench;

constexpr int kFrames = 40;
constexpr std::int64_t kAhead_ns = 6 * Bench::kSecond_ns;
const Eigen::Vector3d kPoint_T(0.3, -0.6, 0.2);

Eigen::Vector3d vector_of(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

Eigen::Matrix3d matrix_of(const std::array<double, 6>& a) {
  Eigen::Matrix3d m;
  m << a[0], a[1], a[2], a[1], a[3], a[4], a[2], a[4], a[5];
  return m;
}

Eigen::Matrix3d R_CT(const MotionState& m) {
  return Eigen::Quaterniond(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]).toRotationMatrix();
}

PointQuestion asked_at(std::int64_t timestamp_ns) {
  return {.timestamp_ns = timestamp_ns,
          .target_frame = 1,
          .p_T = {kPoint_T.x(), kPoint_T.y(), kPoint_T.z()},
          .normal_T = {0.0, 0.0, -1.0}};
}

CommandOctets as_command(const PointQuestion& asked, std::uint32_t number) {
  return command(CommandCode::kPredictPoint,
                 bus::PredictPointCommand{.predicted_timestamp_ns = asked.timestamp_ns,
                                          .p_T = asked.p_T,
                                          .normal_T = asked.normal_T,
                                          .target_frame = asked.target_frame,
                                          .number = number});
}

/// A ball that turns by 3 deg a frame, and what was found of it; asked six frames before the end.
struct Watched {
  Commanded bench;
  std::vector<MotionState> motion;
  PointState ahead;
  std::string_view why = "was not asked";
};

const std::vector<Picture>& pictures() {
  static const std::vector<Picture> rendered = [] {
    const Ball ball(61);
    std::vector<Picture> made;
    for (int i = 0; i < kFrames; ++i) {
      const Eigen::Matrix3d turned = so3_exp(Eigen::Vector3d(0.012, 0.052, 0.005) * i);
      made.push_back(ball.seen_from({.R_CT = turned, .p_CT = {0.02 * i, 0.0, 6.0}}));
    }
    return made;
  }();
  return rendered;
}

std::unique_ptr<Watched> watch() {
  auto w = std::make_unique<Watched>();
  for (int i = 0; i < kFrames; ++i) {
    const StepOutput& out = w->bench.show(pictures()[static_cast<std::size_t>(i)]);
    w->motion.push_back(out.motion);
    if (i == kFrames - 7) {
      w->why = w->bench.component->predict_point(asked_at(out.motion.timestamp_ns + kAhead_ns),
                                                 &w->ahead);
    }
  }
  return w;
}

/// One for all questions by call, which change nothing.
const Watched* watched() {
  static const std::unique_ptr<Watched> one = watch();
  return one.get();
}

// verifies: MOT-14
TEST(PointQuestion, IsAnsweredByWhereThePointThenIs) {
  const Watched* w = watched();
  ASSERT_EQ(w->why, "");
  const PointState& told = w->ahead;
  const MotionState& then = w->motion.back();
  ASSERT_TRUE(then.pose_valid);
  ASSERT_EQ(then.timestamp_ns, told.timestamp_ns);
  EXPECT_EQ(told.timestamp_ns - told.from_timestamp_ns, kAhead_ns);
  ASSERT_TRUE(told.position_valid && told.velocity_valid && told.normal_valid);
  EXPECT_EQ(told.dynamics, 2);
  const Eigen::Vector3d arm = R_CT(then) * kPoint_T;
  const Eigen::Vector3d found = arm + vector_of(then.p_CT);
  // The error of the pose that was measured then: its own, and its attitude's at the point's arm.
  const double sigma_then = std::hypot(then.sigma_pos, arm.norm() * then.sigma_att_rad);
  const Eigen::Matrix3d covariance =
      matrix_of(told.cov_p) + sigma_then * sigma_then * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d off = found - vector_of(told.p_C);
  EXPECT_LT(off.dot(covariance.ldlt().solve(off)), 16.3);  // chi2(3), 99.9 %
  const Eigen::Vector3d facing = R_CT(then) * Eigen::Vector3d(0.0, 0.0, -1.0);
  EXPECT_NEAR(vector_of(told.normal_C).norm(), 1.0, 1e-12);
  const double angle_rad = std::acos(std::min(1.0, facing.dot(vector_of(told.normal_C))));
  EXPECT_LT(angle_rad, 3.0 * (told.sigma_normal_rad + then.sigma_att_rad));
  EXPECT_GT(told.sigma_normal_rad, 0.0);
}

TEST(PointQuestion, OfTheLastFrameIsItsPoseWithinBothErrors_AndItsVelocityThatOfTheArm) {
  const Watched* w = watched();
  const MotionState& now = w->motion.back();
  PointState told;
  ASSERT_EQ(w->bench.component->predict_point(asked_at(now.timestamp_ns), &told), "");
  const Eigen::Vector3d arm = R_CT(now) * kPoint_T;
  const double sigma = std::hypot(now.sigma_pos, arm.norm() * now.sigma_att_rad);
  EXPECT_LT((vector_of(told.p_C) - vector_of(now.p_CT) - arm).norm(), 4.0 * sigma);
  const Eigen::Vector3d v =
      vector_of(now.v_C) + R_CT(now) * vector_of(now.w_T_rad_s).cross(kPoint_T);
  const double sigma_v = std::hypot(now.sigma_vel, kPoint_T.norm() * now.sigma_rate_rad_s);
  EXPECT_LT((vector_of(told.v_C) - v).norm(), 4.0 * sigma_v);
}

TEST(PointQuestion, GrowsLessCertainAhead_AndTheVelocityIsThatOfThePositions) {
  const Watched* w = watched();
  const std::int64_t now_ns = w->motion.back().timestamp_ns;
  double last_sigma = 0.0;
  for (const std::int64_t ahead_s : {0, 10, 60, 120}) {
    PointState one;
    PointState next;
    const std::int64_t then_ns = now_ns + ahead_s * Bench::kSecond_ns;
    ASSERT_EQ(w->bench.component->predict_point(asked_at(then_ns), &one), "");
    ASSERT_EQ(w->bench.component->predict_point(asked_at(then_ns + 1'000'000), &next), "");
    if (!one.position_valid) {
      break;
    }
    const Eigen::Vector3d v = (vector_of(next.p_C) - vector_of(one.p_C)) / 1e-3;
    EXPECT_LT((v - vector_of(one.v_C)).norm(), 1e-4) << ahead_s;
    const double sigma = std::sqrt(matrix_of(one.cov_p).trace());
    EXPECT_GT(sigma, last_sigma) << ahead_s;
    last_sigma = sigma;
  }
  EXPECT_GT(last_sigma, 0.0);
}

TEST(PointQuestion, ByCommandHasTheAnswerOfTheCall_WithTheAskersNumber) {
  const auto w = watch();
  const std::int64_t now_ns = w->motion.back().timestamp_ns;
  PointState told;
  ASSERT_EQ(w->bench.component->predict_point(asked_at(now_ns + kAhead_ns), &told), "");
  const StepOutput& out = w->bench.step(as_command(asked_at(now_ns + kAhead_ns), 4711));
  ASSERT_TRUE(event(EventId::kCommandAccepted, out));
  const auto packets = packets_of<bus::PointPacket>(out);
  ASSERT_EQ(packets.size(), 1U);
  const bus::PointPacket& packet = packets[0];
  EXPECT_EQ(packet.number, 4711U);
  EXPECT_EQ(packet.target_frame, 1U);
  EXPECT_EQ(packet.timestamp_ns, now_ns);
  EXPECT_EQ(packet.predicted_timestamp_ns, now_ns + kAhead_ns);
  EXPECT_EQ(packet.p_C, told.p_C);
  EXPECT_EQ(packet.v_C, told.v_C);
  EXPECT_EQ(packet.normal_C, told.normal_C);
  EXPECT_EQ(packet.dynamics, told.dynamics);
  namespace flag = bus::point_layout;
  EXPECT_EQ(packet.flags & 0x0F, flag::kFlagPosition | flag::kFlagVelocity | flag::kFlagNormal);
  for (std::size_t i = 0; i < told.cov_p.size(); ++i) {
    EXPECT_FLOAT_EQ(packet.cov_p[i], static_cast<float>(told.cov_p[i]));
    EXPECT_FLOAT_EQ(packet.cov_v[i], static_cast<float>(told.cov_v[i]));
  }
}

TEST(PointQuestion, WithoutANormalTellsNone) {
  const Watched* w = watched();
  PointQuestion asked = asked_at(w->motion.back().timestamp_ns);
  asked.normal_T = {};
  PointState told;
  ASSERT_EQ(w->bench.component->predict_point(asked, &told), "");
  EXPECT_TRUE(told.position_valid);
  EXPECT_FALSE(told.normal_valid);
  EXPECT_EQ(told.normal_C, (std::array<double, 3>{}));
  EXPECT_EQ(told.sigma_normal_rad, 0.0);
}

TEST(PointQuestion, ThatCannotBeAnsweredIsRefusedWithItsReason_AndTouchesNothing) {
  const auto w = watch();
  const std::int64_t now_ns = w->motion.back().timestamp_ns;
  const auto why = [&](const PointQuestion& asked) {
    PointState told{.timestamp_ns = 77};
    const std::string_view reason = w->bench.component->predict_point(asked, &told);
    EXPECT_EQ(told.timestamp_ns, reason.empty() ? asked.timestamp_ns : 77);
    return reason;
  };
  EXPECT_EQ(why(asked_at(now_ns - 1)), "time is before the last frame");
  PointQuestion asked = asked_at(now_ns);
  asked.target_frame = 9;
  EXPECT_EQ(why(asked), "point is of another frame T");
  asked = asked_at(now_ns);
  asked.normal_T = {0.0, 0.5, 0.0};
  EXPECT_EQ(why(asked), "normal is no unit vector");
  asked = asked_at(now_ns);
  asked.p_T[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(why(asked), "point is no number");
  // 3 deg a second: 100 rad take half an hour.
  EXPECT_EQ(why(asked_at(now_ns + 3000 * Bench::kSecond_ns)), "no motion is known so far ahead");
  EXPECT_EQ(why(asked_at(now_ns + 1500 * Bench::kSecond_ns)), "");
  const StepOutput& out = w->bench.step(as_command(asked_at(now_ns - 1), 1));
  EXPECT_TRUE(event(EventId::kCommandState, out));
  EXPECT_TRUE(packets_of<bus::PointPacket>(out).empty());
}

TEST(PointQuestion, BeforeAMapIsRefused) {
  Commanded bench;
  PointState told;
  EXPECT_EQ(bench.component->predict_point(asked_at(Bench::kSecond_ns), &told), "no map");
}

TEST(PointQuestion, ByTheLastPosesAloneReachesTenSeconds_WithoutAVelocity) {
  Parameters p = Commanded::every_frame();
  p.motion.mode = MotionMode::kPaper;
  Commanded bench(p);
  MotionState now;
  for (int i = 0; i < 30; ++i) {
    now = bench.show(pictures()[static_cast<std::size_t>(i)]).motion;
  }
  ASSERT_TRUE(now.pose_valid);
  PointState told;
  ASSERT_EQ(
      bench.component->predict_point(asked_at(now.timestamp_ns + 2 * Bench::kSecond_ns), &told),
      "");
  EXPECT_EQ(told.dynamics, 1);
  EXPECT_TRUE(told.position_valid);
  EXPECT_FALSE(told.velocity_valid);
  EXPECT_EQ(
      bench.component->predict_point(asked_at(now.timestamp_ns + 11 * Bench::kSecond_ns), &told),
      "no motion is known so far ahead");
}

}  // namespace
}  // namespace polhode::point_question_test
