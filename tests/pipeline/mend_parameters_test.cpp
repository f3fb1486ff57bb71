// Parameters that bit flips have hit, in one place or in several.
#include "pipeline/mend_parameters.hpp"

#include <gtest/gtest.h>

#include "damages.hpp"
#include "packets_of.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/scrub.hpp"

namespace polhode::mend_parameters_test {
namespace {

using namespace bench;

class MendParameters : public testing::Test {
 protected:
  [[nodiscard]] Configuration& c() const { return state_of(*bench_.component).configuration; }
  void expect_as_before() const { EXPECT_EQ(table_crc(c().parameters), table_crc(before_)); }

  static Parameters of_no_default() {
    Parameters p = parameters();
    p.seed = 7;
    return p;
  }
  Bench bench_{of_no_default()};
  Parameters before_ = c().parameters;
};

TEST_F(MendParameters, WithoutDamageNothingIsDone) {
  EXPECT_FALSE(mend_parameters(&c()).any());
  expect_as_before();
}

TEST_F(MendParameters, OfTheTableItsCopyAndTheCrcOneMayBeHit) {
  c().parameters.features.count_max += 8;
  EXPECT_EQ(mend_parameters(&c()).entries, 1U);
  expect_as_before();
  c().spare.features.count_max += 8;  // noticed where the table itself is hit, too
  EXPECT_FALSE(mend_parameters(&c()).any());
  c().spare = c().parameters;
  c().table_crc ^= 1U << 5U;
  EXPECT_EQ(mend_parameters(&c()).entries, 1U);
  EXPECT_EQ(c().table_crc, table_crc(before_));
  expect_as_before();
}

TEST_F(MendParameters, HitInBothTables_ButInNoValueTwice_AreAsTheyWere) {
  c().parameters.features.count_max += 8;
  c().parameters.seed ^= 1U << 9U;
  c().spare.camera.fu_px *= 2.0;
  c().spare.mask.dark_level *= 2.0;
  const Repair repaired = mend_parameters(&c());
  EXPECT_TRUE(repaired.any());
  EXPECT_FALSE(repaired.reset);
  expect_as_before();
}

TEST_F(MendParameters, AValueHitInBothTablesIsItsDefault_AndTheRestStays) {
  const Parameters defaults;
  ASSERT_NE(before_.seed, defaults.seed) << "else the test says nothing";
  c().parameters.seed ^= 1U << 9U;
  c().spare.seed ^= 1U << 10U;
  const Repair repaired = mend_parameters(&c());
  EXPECT_TRUE(repaired.reset);
  EXPECT_EQ(repaired.entries, 1U);
  Parameters expected = before_;
  expected.seed = defaults.seed;
  EXPECT_EQ(table_crc(c().parameters), table_crc(expected));
  EXPECT_EQ(c().table_crc, table_crc(expected));
  EXPECT_FALSE(mend_parameters(&c()).any());
}

TEST_F(MendParameters, TheCameraIsWhatTheModelTells_WhereACopyHasItStill) {
  c().parameters.camera.fu_px *= 2.0;
  c().parameters.seed ^= 1U << 9U;
  c().spare.seed ^= 1U << 10U;
  EXPECT_TRUE(mend_parameters(&c()).reset);
  EXPECT_EQ(c().parameters.camera.fu_px, before_.camera.fu_px);
}

TEST_F(MendParameters, WithoutACameraTheRunBeginsAnew) {
  c().parameters.camera.fu_px *= 2.0;
  c().spare.camera.fu_px *= 4.0;
  EXPECT_DEATH((void)mend_parameters(&c()), "");
}

TEST_F(MendParameters, AStepCountsAndTellsIt_AndLosesATargetOfOtherParameters) {
  ASSERT_TRUE(restore_checkpoint(good_checkpoint(), bench_.component));
  ASSERT_TRUE(show(bench_, kFramesBefore).motion.pose_valid);
  c().parameters.seed ^= 1U << 9U;
  c().spare.seed ^= 1U << 10U;
  const StepOutput& out = show(bench_, kFramesBefore + 1);
  EXPECT_FALSE(out.motion.pose_valid);
  EXPECT_EQ(state_of(*bench_.component).bus.tables_damaged, 1U);
  EXPECT_TRUE(is_valid(state_of(*bench_.component)));
}

}  // namespace
}  // namespace polhode::mend_parameters_test
