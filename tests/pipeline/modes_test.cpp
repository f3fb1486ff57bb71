// The table of the modes: what each event leads to, from each mode, held or not.
#include "pipeline/modes.hpp"

#include <gtest/gtest.h>

namespace polhode::modes_test {
namespace {

constexpr Mode kModes[] = {
    Mode::kIdle, Mode::kAcquiring, Mode::kTracking, Mode::kLost, Mode::kCoasting};

Mode after(ModeEvent event, Mode from, bool held) {
  ModeState mode{.now = from, .held = held};
  change_mode(event, &mode);
  EXPECT_EQ(mode.held, held) << "commands alone say that";
  return mode.now;
}

TEST(Modes, AComponentThatIsHeldIsIdleFromItsNextFrameOn) {
  for (const Mode from : kModes) {
    EXPECT_EQ(after(ModeEvent::kFrameComes, from, true), Mode::kIdle);
  }
}

TEST(Modes, WhileHeldNothingLeadsOutOfIdle) {
  for (const ModeEvent event : {ModeEvent::kMapBegun,
                                ModeEvent::kPoseFound,
                                ModeEvent::kPoseNotFound,
                                ModeEvent::kTargetReset,
                                ModeEvent::kResumedWithMap,
                                ModeEvent::kResumedWithoutMap}) {
    EXPECT_EQ(after(event, Mode::kIdle, true), Mode::kIdle);
  }
}

TEST(Modes, AFrameBeginsTheSearch_AndDisturbsNothingElse) {
  EXPECT_EQ(after(ModeEvent::kFrameComes, Mode::kIdle, false), Mode::kAcquiring);
  for (const Mode from : {Mode::kAcquiring, Mode::kTracking, Mode::kLost, Mode::kCoasting}) {
    EXPECT_EQ(after(ModeEvent::kFrameComes, from, false), from);
  }
}

TEST(Modes, AMapLeadsFromTheSearchToTracking) {
  EXPECT_EQ(after(ModeEvent::kMapBegun, Mode::kAcquiring, false), Mode::kTracking);
  EXPECT_EQ(after(ModeEvent::kMapBegun, Mode::kLost, false), Mode::kTracking);
}

TEST(Modes, WithoutAMapNoPoseIsFoundOrMissed) {
  EXPECT_EQ(after(ModeEvent::kPoseFound, Mode::kAcquiring, false), Mode::kAcquiring);
  EXPECT_EQ(after(ModeEvent::kPoseNotFound, Mode::kAcquiring, false), Mode::kAcquiring);
}

TEST(Modes, PosesLeadBetweenTrackingAndLost) {
  for (const Mode from : {Mode::kTracking, Mode::kLost, Mode::kCoasting}) {
    EXPECT_EQ(after(ModeEvent::kPoseFound, from, false), Mode::kTracking);
    EXPECT_EQ(after(ModeEvent::kPoseNotFound, from, false), Mode::kLost);
  }
}

TEST(Modes, APoseIsPredictedOnlyAfterOneThatWasFound) {
  EXPECT_EQ(after(ModeEvent::kPosePredicted, Mode::kTracking, false), Mode::kCoasting);
  EXPECT_EQ(after(ModeEvent::kPosePredicted, Mode::kCoasting, false), Mode::kCoasting);
  for (const Mode from : {Mode::kIdle, Mode::kAcquiring, Mode::kLost}) {
    EXPECT_EQ(after(ModeEvent::kPosePredicted, from, false), from);
  }
  EXPECT_EQ(after(ModeEvent::kPosePredicted, Mode::kTracking, true), Mode::kTracking);
}

TEST(Modes, AWarmStartLooksForTheTargetThatItKnows) {
  EXPECT_EQ(after(ModeEvent::kWarmStartWithMap, Mode::kIdle, false), Mode::kLost);
  EXPECT_EQ(after(ModeEvent::kWarmStartWithoutMap, Mode::kIdle, false), Mode::kIdle);
}

}  // namespace
}  // namespace polhode::modes_test
