// Bits that flip in a component's memory between two steps.
#include "pipeline/scrub.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "base/rng.hpp"
#include "damages.hpp"
#include "packets_of.hpp"

namespace polhode::scrub_test {
namespace {

using namespace bench;

/// As it was after kFramesBefore frames. The next frame finds the target again.
Bench& begun(Bench& b) {
  EXPECT_TRUE(restore_checkpoint(good_checkpoint(), b.component));
  EXPECT_TRUE(show(b, kFramesBefore).motion.pose_valid);
  EXPECT_EQ(state_of(*b.component).bus.tables_damaged, 0U);
  return b;
}

/// Of these the target is lost: nothing tells where it was.
const std::set<std::string> kResets{"keyframes' count", "landmarks' count", "the drift"};

TEST(Scrub, EachDamageIsPutRightCountedAndReported) {
  for (const Damage& damage : damages()) {
    Bench memory(parameters());
    Bench& b = begun(memory);
    Component::State& s = state_of(*b.component);
    damage.done(s);
    ASSERT_FALSE(is_valid(s)) << damage.what;
    const StepOutput& out = show(b, kFramesBefore + 1);
    EXPECT_TRUE(is_valid(s)) << damage.what;
    EXPECT_EQ(s.bus.tables_damaged, 1U) << damage.what;
    const auto events = packets_of<bus::EventPacket>(out);
    EXPECT_EQ(std::count_if(events.begin(),
                            events.end(),
                            [](const bus::EventPacket& event) {
                              return event.id ==
                                     static_cast<std::uint16_t>(bus::EventId::kTableDamaged);
                            }),
              1)
        << damage.what;
    EXPECT_EQ(out.motion.pose_valid, !kResets.contains(damage.what)) << damage.what;
  }
}

TEST(Scrub, ParametersAreThoseOfTheStepBefore) {
  Bench memory(parameters());
  Bench& b = begun(memory);
  Component::State& s = state_of(*b.component);
  const Parameters before = s.configuration.parameters;
  s.configuration.parameters.features.count_max ^= 1 << 20;
  s.configuration.camera.fu_px = kNan;
  scrub(&s);
  EXPECT_EQ(s.configuration.parameters.features.count_max, before.features.count_max);
  EXPECT_EQ(s.configuration.camera.fu_px, before.camera.fu_px);
}

TEST(Scrub, NothingIsTakenFromAMapButWhatIsDamaged) {
  Bench memory(parameters());
  Bench& b = begun(memory);
  Component::State& s = state_of(*b.component);
  const int keyframes = s.mapping.map.keyframe_count;
  const int landmarks = s.mapping.map.landmark_count;
  first_landmark(s).p_T.x() = kNan;
  first_keyframe(s).features[0].u_px = 1e6F;
  scrub(&s);
  EXPECT_EQ(s.mapping.map.keyframe_count, keyframes);
  EXPECT_GE(s.mapping.map.landmark_count, landmarks - 2);  // that of the feature may go, too
  EXPECT_LT(s.mapping.map.landmark_count, landmarks);
}

TEST(Scrub, NoCheckpointIsMadeOfADamagedState) {
  Bench memory(parameters());
  Bench& b = begun(memory);
  first_landmark(state_of(*b.component)).p_T.x() = kNan;
  EXPECT_FALSE(may_be_saved(*b.component));
  show(b, kFramesBefore + 1);
  EXPECT_TRUE(may_be_saved(*b.component));
}

/// Within an object that holds no pointers.
template <typename T>
void flip(int flips, Rng* rng, T* object) {
  auto* octets = reinterpret_cast<std::uint8_t*>(object);
  for (int i = 0; i < flips; ++i) {
    const auto bit =
        static_cast<std::size_t>(rng->uniform() * 8.0 * static_cast<double>(sizeof(T)));
    octets[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
  }
}

TEST(Scrub, WithFlippedBitsInItsTablesTheStepsGoOn) {
  constexpr int kTrials = 24;  // three of each number of flips
  int damaged = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Rng rng(2, static_cast<std::uint64_t>(trial));
    Bench memory(parameters());
    Bench& b = begun(memory);
    Component::State& s = state_of(*b.component);
    const int flips = 16 << (trial % 8);
    flip(flips, &rng, &s.mapping.map);
    flip(1 + flips / 32, &rng, &s.motion);
    flip(1 + flips / 64, &rng, &s.initialisation);
    for (int i = kFramesBefore + 1; i < kFrames; ++i) {
      show(b, i);
      ASSERT_TRUE(is_valid(s)) << "trial " << trial;
    }
    damaged += s.bus.tables_damaged > 0 ? 1 : 0;
  }
  EXPECT_GT(damaged, 0);
}

}  // namespace
}  // namespace polhode::scrub_test
