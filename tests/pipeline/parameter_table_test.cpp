// A table of parameters that is loaded and activated in flight.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/crc.hpp"
#include "commanded.hpp"
#include "pipeline/commands.hpp"
#include "pipeline/parameter_image.hpp"
#include "state_of.hpp"

namespace polhode::parameter_table_test {
namespace {

using namespace bench;

bus::TableLoadEntry entry(const char* key, std::uint64_t value) {
  return {.key_crc = key_crc(key), .value = value};
}
bus::TableLoadEntry entry(const char* key, double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return entry(key, bits);
}

CommandOctets activation(const std::vector<bus::TableLoadEntry>& entries) {
  const CommandOctets load = bus::table_load(entries);
  bus::Command read;
  EXPECT_EQ(bus::read_command(load, BusOptions{}.apid_first, &read).reason, bus::Rejection::kNone);
  return command(CommandCode::kTableActivate,
                 bus::TableActivateCommand{.crc32 = crc32_iso_hdlc(read.entry_octets()),
                                           .entries = static_cast<std::uint32_t>(entries.size())});
}

// verifies: CMD-04
TEST(ParameterTable, IsLoadedApart_AndSwappedByActivationOnly) {
  Commanded bench;
  const Parameters& active = state_of(*bench.component).configuration.parameters;
  const std::uint32_t crc_before = table_crc(active);
  const std::vector entries = {entry("features.count_max", std::uint64_t{321}),
                               entry("features.sigma_px", 0.5)};
  const auto loaded = Commanded::housekeeping(bench.step(bus::table_load(entries)));
  EXPECT_EQ(loaded.table_entries, 2);
  EXPECT_EQ(loaded.table_crc, crc_before);
  EXPECT_NE(active.features.count_max, 321);
  const StepOutput& out = bench.step(activation(entries));
  EXPECT_TRUE(event(EventId::kTableActivated, out));
  EXPECT_EQ(active.features.count_max, 321);
  EXPECT_EQ(active.features.sigma_px, 0.5);
  const auto told = Commanded::housekeeping(out);
  EXPECT_NE(told.table_crc, crc_before);
  EXPECT_EQ(told.table_crc, table_crc(active));
  EXPECT_EQ(told.table_entries, 0);
}

TEST(ParameterTable, WithOneBadEntryTakesNoneOfThePacket) {
  const std::vector<bus::TableLoadEntry> bad = {
      entry("features.count_max", std::uint64_t{5000}),
      entry("features.count_max", std::uint64_t{0xFFFFFFFF00000100}),
      entry("features.sigma_px", std::nan("")),
      entry("features.sigma_px", 1e9),
      entry("features.no_such_key", std::uint64_t{1}),
      entry("mask.enabled", std::uint64_t{2}),
      entry("camera.width_px", std::uint64_t{640}),
      entry("seed", std::uint64_t{7}),
      entry("bus.apid_first", std::uint64_t{7}),
      {.key_crc = key_crc("features.sigma_px"), .index = 1, .value = 0}};
  for (std::size_t i = 0; i < bad.size(); ++i) {
    Commanded bench;
    const StepOutput& out = bench.step(
        bus::table_load(std::vector{entry("features.count_max", std::uint64_t{300}), bad[i]}));
    EXPECT_TRUE(event(EventId::kTableRefused, out)) << i;
    const auto told = Commanded::housekeeping(out);
    EXPECT_EQ(told.commands_rejected, 1U) << i;
    EXPECT_EQ(told.table_entries, 0) << i;
    EXPECT_EQ(told.flags & bus::housekeeping_layout::kFlagTableLoaded, 0) << i;
  }
}

// verifies: CMD-04
TEST(ParameterTable, IsNotActivatedWithAnotherChecksumOrCount_NorWithoutALoad) {
  Commanded bench;
  const std::vector entries = {entry("features.count_max", std::uint64_t{321})};
  EXPECT_TRUE(event(EventId::kTableNotActivated, bench.step(activation(entries))));
  (void)bench.step(bus::table_load(entries));
  for (const bus::TableActivateCommand& wrong :
       {bus::TableActivateCommand{.crc32 = 1, .entries = 1},
        bus::TableActivateCommand{.crc32 = state_of(*bench.component).configuration.inactive.crc,
        .entries = 2}}) {
    EXPECT_TRUE(event(EventId::kTableNotActivated,
                      bench.step(command(CommandCode::kTableActivate, wrong))));
  }
  EXPECT_NE(state_of(*bench.component).configuration.parameters.features.count_max, 321);
  EXPECT_TRUE(event(EventId::kTableActivated, bench.step(activation(entries))));
}

TEST(ParameterTable, WhoseValuesContradictEachOtherIsNotActivated) {
  Commanded bench;
  const std::vector entries = {entry("start.chi2_gap_commit", 10.0),
                               entry("start.chi2_gap_convexity", 20.0)};
  (void)bench.step(bus::table_load(entries));
  const StepOutput& out = bench.step(activation(entries));
  const auto told = event(EventId::kTableNotActivated, out);
  ASSERT_TRUE(told);
  EXPECT_NE(std::string(told->text.data()).find("chi2_gap"), std::string::npos);
}

TEST(ParameterTable, SwitchesAMaskAgainstABackgroundOn_OnlyWhereMemoryWasPlannedForOne) {
  const std::vector off = {entry("mask.background", std::uint64_t{0})};
  const std::vector on = {entry("mask.background", std::uint64_t{1})};
  const auto activates = [](const auto& entries, Commanded* bench) {
    (void)bench->step(bus::table_load(entries));
    return event(EventId::kTableActivated, bench->step(activation(entries))).has_value();
  };
  Commanded planned;
  EXPECT_TRUE(activates(off, &planned));
  EXPECT_TRUE(activates(on, &planned));
  Parameters without = Commanded::every_frame();
  without.mask.background = false;
  Commanded unplanned(without);
  EXPECT_TRUE(activates(off, &unplanned));
  EXPECT_FALSE(activates(on, &unplanned));
  EXPECT_FALSE(state_of(*unplanned.component).configuration.parameters.mask.background);
}

TEST(ParameterTable, IsForgottenOnDiscard) {
  Commanded bench;
  (void)bench.step(bus::table_load(std::vector{entry("features.count_max", std::uint64_t{321})}));
  EXPECT_EQ(Commanded::housekeeping(bench.step(command(CommandCode::kTableDiscard))).table_entries,
            0);
  EXPECT_TRUE(event(EventId::kCommandState, bench.step(command(CommandCode::kTableDiscard))));
}

TEST(ParameterTable, HasOneNameAKey) {
  for (const ParameterRow& row : parameter_table()) {
    EXPECT_EQ(find_parameter_by_crc(key_crc(row.key)), &row) << row.key;
  }
}

TEST(ParameterTable, TakesBackTheBitsOfItsOwnDefaults) {
  Parameters p = parameters();
  for (const ParameterRow& row : parameter_table()) {
    if (has_no_default(row.key)) {
      continue;
    }
    const std::uint64_t bits = bits_of(row, 0, p);
    EXPECT_TRUE(set_from_bits(row, 0, bits, &p)) << row.key;
    EXPECT_EQ(bits_of(row, 0, p), bits) << row.key;
  }
  EXPECT_EQ(first_bad_key(p), "");
  p.features.sigma_px = -1.0;
  EXPECT_EQ(first_bad_key(p), "features.sigma_px");
}

}  // namespace
}  // namespace polhode::parameter_table_test
