// A checkpoint whose octets are whole, but whose values were damaged before it was written.
#include "pipeline/soundness.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/rng.hpp"
#include "damages.hpp"

namespace polhode::soundness_test {
namespace {

using namespace bench;

// verifies: CMP-09
TEST(Soundness, OfAStateThatWasDamagedBeforeItWasWritten_NothingIsTaken) {
  for (const Damage& damage : damages()) {
    Bench spoilt(parameters());
    ASSERT_TRUE(restore_checkpoint(good_checkpoint(), spoilt.component));
    ASSERT_TRUE(is_valid(state_of(*spoilt.component)));
    damage.done(state_of(*spoilt.component));
    EXPECT_FALSE(is_valid(state_of(*spoilt.component))) << damage.what;

    Bench b(parameters());
    EXPECT_FALSE(restore_checkpoint(saved(spoilt), b.component)) << damage.what;
    // As it was created: the same packets as one that was never asked.
    Bench fresh(parameters());
    const auto got = show(b, 0).packets;
    const auto wanted = show(fresh, 0).packets;
    EXPECT_TRUE(std::equal(got.begin(), got.end(), wanted.begin(), wanted.end())) << damage.what;
  }
}

// verifies: CMP-09
TEST(Soundness, WithFlippedBitsItIsRefusedOrTheStepsGoOn) {
  constexpr int kTrials = 30;  // takes 3 s; 3000 were run once
  int taken = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Rng rng(1, static_cast<std::uint64_t>(trial));
    std::vector<std::uint8_t> octets = good_checkpoint();
    for (int flip = 0; flip < 1 << (trial % 8); ++flip) {
      const auto bit =
          static_cast<std::size_t>(rng.uniform() * 8.0 * static_cast<double>(octets.size()));
      octets[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    }
    Bench b(parameters());
    taken += restore_checkpoint(octets, b.component) ? 1 : 0;
    for (int i = kFramesBefore; i < kFrames; ++i) {
      show(b, i);
    }
  }
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, kTrials);
}

}  // namespace
}  // namespace polhode::soundness_test
