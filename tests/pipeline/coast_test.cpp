// COASTING on rendered pictures of a ball that turns: what is told of frames that cannot be looked
// at.
#include "pipeline/coast.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "bench.hpp"
#include "geometry/so3.hpp"
#include "state_of.hpp"

namespace polhode::coast_test {
namespace {

using namespace bench;

constexpr int kShown = 16;
constexpr int kFrames = 24;

const std::vector<Picture>& pictures() {
  static const std::vector<Picture> rendered = images_of_turning(kFrames);
  return rendered;
}

const StepOutput& step_blindly(Bench* b) {
  return b->component->step({.frame = unreadable(++b->time_s * Bench::kSecond_ns)});
}

// verifies: CMP-10
TEST(Coast, TellsTheMotionsPrediction_WithASigmaThatGrows) {
  Bench b;
  show_first(pictures(), kShown - 1, &b);
  const MotionState last = b.show(pictures()[kShown - 1]).motion;
  ASSERT_EQ(last.mode, Mode::kTracking);
  double sigma_rad = 0.0;
  for (int i = kShown; i < kShown + 3; ++i) {
    const MotionState m = step_blindly(&b).motion;
    ASSERT_EQ(m.mode, Mode::kCoasting) << i;
    EXPECT_TRUE(m.pose_valid);
    EXPECT_FALSE(is_measured(m));
    EXPECT_FALSE(m.rate_valid);
    const double error_rad =
        rotation_angle_rad(rotation_of(m) * rotation_of(last).transpose(),
                           turning(i).R_CT * turning(kShown - 1).R_CT.transpose());
    EXPECT_LT(error_rad, 3.0 * m.sigma_att_rad) << i;
    EXPECT_GT(m.sigma_att_rad, sigma_rad) << i;
    sigma_rad = m.sigma_att_rad;
  }
  const MotionState back = b.show(pictures()[kShown + 3]).motion;
  EXPECT_EQ(back.mode, Mode::kTracking);
  EXPECT_TRUE(is_measured(back));
  EXPECT_EQ(b.component->counters().lost, 0U);
}

// verifies: CMP-10
TEST(Coast, EndsInALoss_BeforeThePredictionIsThreeDegreesOff) {
  Bench b;
  show_first(pictures(), kShown, &b);
  int coasted = 0;
  MotionState m = step_blindly(&b).motion;
  for (; m.mode == Mode::kCoasting && coasted < 2000; ++coasted) {
    EXPECT_LT(m.sigma_att_rad, 0.053);
    m = step_blindly(&b).motion;
  }
  EXPECT_GT(coasted, 0);
  EXPECT_EQ(m.mode, Mode::kLost);
  EXPECT_FALSE(m.pose_valid);
  EXPECT_EQ(b.component->counters().lost, 1U);
}

TEST(Coast, DoesNothing_BeforeThereIsAPose) {
  Bench b;
  show_first(pictures(), 3, &b);
  const MotionState m = step_blindly(&b).motion;
  EXPECT_EQ(m.mode, Mode::kAcquiring);
  EXPECT_FALSE(m.pose_valid);
}

TEST(Coast, TellsNothing_OfATimeThatIsOver) {
  Bench b;
  show_first(pictures(), kShown, &b);
  const MotionState m =
      b.component->step({.frame = unreadable(b.time_s * Bench::kSecond_ns)}).motion;
  EXPECT_FALSE(m.pose_valid);
  EXPECT_EQ(m.mode, Mode::kTracking);
}

TEST(Coast, TellsNothing_WhileAPoseDepartsFromTheMotion) {
  Bench b;
  show_first(pictures(), kShown, &b);
  const std::int64_t next_ns = (b.time_s + 1) * Bench::kSecond_ns;
  Component::State& s = state_of(*b.component);
  ASSERT_TRUE(coasted_pose(next_ns, s));
  s.motion.departures = 1;
  EXPECT_FALSE(coasted_pose(next_ns, s));
}

}  // namespace
}  // namespace polhode::coast_test
