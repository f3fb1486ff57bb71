// Commands through a whole component, and what it tells of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <optional>

#include "../bus/command_packets.hpp"
#include "base/crc.hpp"
#include "bench.hpp"
#include "packets_of.hpp"
#include "pipeline/commands.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

using namespace bench;
using bus::command;
using bus::CommandCode;
using bus::CommandOctets;
using bus::EventId;

std::optional<bus::EventPacket> event(EventId id, const StepOutput& out) {
  for (const bus::EventPacket& packet : packets_of<bus::EventPacket>(out)) {
    if (packet.id == static_cast<std::uint16_t>(id)) {
      return packet;
    }
  }
  return std::nullopt;
}

struct Commanded : Bench {
  explicit Commanded(const Parameters& p = every_frame()) : Bench(p) {}
  static Parameters every_frame() {
    Parameters p = parameters();
    p.bus.housekeeping_every_frames = 1;
    return p;
  }
  /// A dark frame (nothing to see, quick) with these commands.
  const StepOutput& step(const std::vector<CommandOctets>& commands) {
    const std::vector<std::span<const std::uint8_t>> spans(commands.begin(), commands.end());
    return component->step({.frame = frame_of(++time_s * kSecond_ns, dark), .commands = spans});
  }
  const StepOutput& step(const CommandOctets& one) { return step(std::vector<CommandOctets>{one}); }
  static bus::HousekeepingPacket housekeeping(const StepOutput& out) {
    const auto packets = packets_of<bus::HousekeepingPacket>(out);
    EXPECT_EQ(packets.size(), 1U);
    return packets.at(0);
  }
  const Picture dark = uniform(0);
};

TEST(Commands, NoopAnswersWithTheVersion) {
  Commanded bench;
  const StepOutput& out = bench.step(command(CommandCode::kNoop));
  const auto answer = event(EventId::kNoop, out);
  ASSERT_TRUE(answer);
  EXPECT_EQ(std::string(answer->text.data()), std::string("NOOP, version ") + kVersion);
  const auto told = Commanded::housekeeping(out);
  EXPECT_EQ(told.commands_accepted, 1U);
  EXPECT_EQ(told.last_command, 0);
  EXPECT_EQ(told.version, (std::array<std::uint8_t, 3>{0, 1, 0}));
}

TEST(Commands, ThatAreDamagedChangeNothingButTheirCounter) {
  Commanded bench;
  CommandOctets damaged = command(CommandCode::kHold);
  damaged.back() ^= 1;
  const StepOutput& out = bench.step(damaged);
  EXPECT_TRUE(event(EventId::kCommandCrc, out));
  const auto told = Commanded::housekeeping(out);
  EXPECT_EQ(told.commands_accepted, 0U);
  EXPECT_EQ(told.commands_rejected, 1U);
  EXPECT_EQ(told.last_rejection, static_cast<std::uint8_t>(bus::Rejection::kCrc));
  EXPECT_EQ(told.flags & bus::housekeeping_layout::kFlagHeld, 0);
}

TEST(Commands, EachIsCountedAndAnswered_UnknownOnesToo) {
  Commanded bench;
  const std::vector<CommandOctets> commands = {command(static_cast<CommandCode>(99)),
                                               command(CommandCode::kResume),
                                               {},
                                               command(CommandCode::kCheckpoint)};
  const StepOutput& out = bench.step(commands);
  EXPECT_TRUE(event(EventId::kCommandUnknown, out));
  EXPECT_TRUE(event(EventId::kCommandState, out));
  EXPECT_TRUE(event(EventId::kCommandLength, out));
  EXPECT_TRUE(event(EventId::kCommandAccepted, out));
  EXPECT_TRUE(out.checkpoint_asked);
  const auto told = Commanded::housekeeping(out);
  EXPECT_EQ(told.commands_accepted, 1U);
  EXPECT_EQ(told.commands_rejected, 3U);
  EXPECT_FALSE(bench.step(std::vector<CommandOctets>()).checkpoint_asked);
}

TEST(Commands, BeyondAStepsLimitAreRejected_AndCountedEach) {
  Commanded bench;
  const std::vector<CommandOctets> flood(limits::kStepCommands + 5, command(CommandCode::kNoop));
  const StepOutput& out = bench.step(flood);
  EXPECT_TRUE(event(EventId::kCommandTooMany, out));
  const auto told = Commanded::housekeeping(out);
  EXPECT_EQ(told.commands_accepted, limits::kStepCommands);
  EXPECT_EQ(told.commands_rejected, 5U);
}

TEST(Commands, ResetCountersLeavesFrameAndSequenceAlone) {
  Commanded bench;
  for (int i = 0; i < 3; ++i) {
    (void)bench.step(command(CommandCode::kNoop));
  }
  const StepOutput& out = bench.step(command(CommandCode::kResetCounters));
  const auto told = Commanded::housekeeping(out);
  EXPECT_EQ(told.frame, 3U);
  EXPECT_EQ(told.frames_in, 1U);
  EXPECT_EQ(told.commands_accepted, 1U);
  EXPECT_EQ(((out.packets[2] & 0x3F) << 8) | out.packets[3], 3);
}

TEST(Commands, HoldPassesFramesOver_UntilResume) {
  Commanded bench;
  EXPECT_EQ(bench.step(command(CommandCode::kHold)).use, FrameUse::kHeld);
  EXPECT_EQ(bench.show(noise(1)).motion.mode, Mode::kIdle);
  const StepOutput& again = bench.step(command(CommandCode::kHold));
  EXPECT_TRUE(event(EventId::kCommandState, again));
  EXPECT_EQ(Commanded::housekeeping(again).frames_held, 3U);
  EXPECT_EQ(packets_of<bus::MotionPacket>(again).size(), 1U);
  (void)bench.step(command(CommandCode::kResume));
  const StepOutput& out = bench.show(noise(1));
  EXPECT_EQ(out.use, FrameUse::kUsed);
  EXPECT_EQ(out.motion.mode, Mode::kAcquiring);
}

TEST(Commands, WhatWasCollectedForAStartIsOld_AfterAHold) {
  const Ball ball(3);
  Commanded bench;
  for (int i = 0; i < 4; ++i) {
    (void)bench.show(ball.seen_from(turning(i)));
  }
  const Component::State& state = bench.component->state();
  ASSERT_FALSE(state.tracks.frames.empty());
  (void)bench.step(command(CommandCode::kHold));
  EXPECT_TRUE(state.tracks.frames.empty());
  (void)bench.show(ball.seen_from(turning(5)));
  (void)bench.step(command(CommandCode::kResume));
  const Counters& counters = bench.component->counters();
  EXPECT_EQ(counters.frames_held, 2U);
  EXPECT_EQ(counters.frames_missing, 0U) << "held is not missing";
}

TEST(Commands, LengthAndRangeReplaceEachOther) {
  Commanded bench;
  (void)bench.step(command(CommandCode::kSetKnownLength,
                           bus::SetKnownLengthCommand{.frame_timestamp_ns = 5,
                                                      .length_m = 0.6,
                                                      .first_px = {1.0, 2.0},
                                                      .second_px = {30.0, 40.0}}));
  const ScaleOptions& scale = bench.component->state().parameters.scale;
  EXPECT_EQ(scale.known_length_m, 0.6);
  EXPECT_EQ(scale.points_px[1][1], 40.0);
  (void)bench.step(command(CommandCode::kSetRange,
                           bus::SetRangeCommand{.frame_timestamp_ns = 7, .range_m = 12.5}));
  EXPECT_EQ(scale.known_length_m, 0.0);
  EXPECT_EQ(scale.range_m, 12.5);
  const StepOutput& out =
      bench.step(command(CommandCode::kSetKnownLength,
                         bus::SetKnownLengthCommand{.frame_timestamp_ns = 5,
                                                    .length_m = 0.6,
                                                    .first_px = {1.0, 2.0},
                                                    .second_px = {30.0, 4000.0}}));
  EXPECT_TRUE(event(EventId::kCommandState, out));
  EXPECT_EQ(scale.known_length_m, 0.0);
}

TEST(Commands, LengthAndRangeLeaveAloneWhatIsKnownOfTheShape) {
  Parameters p = Commanded::every_frame();
  p.scale.known_diameter_m = 2.0;
  p.scale.range_sigma_m = 0.05;
  Bench bench(p);
  const CommandOctets range = command(
      CommandCode::kSetRange, bus::SetRangeCommand{.frame_timestamp_ns = 7, .range_m = 12.5});
  const std::array<std::span<const std::uint8_t>, 1> commands{range};
  const Picture dark = uniform(0);
  const StepOutput& out = bench.component->step(
      {.frame = frame_of(Bench::kSecond_ns, dark), .commands = commands});
  const Parameters& now = bench.component->state().parameters;
  EXPECT_EQ(now.scale.range_m, 12.5);
  EXPECT_EQ(now.scale.known_diameter_m, 2.0);
  EXPECT_EQ(now.scale.range_sigma_m, 0.05);
  EXPECT_EQ(Commanded::housekeeping(out).table_crc, table_crc(now));
}

TEST(Commands, ALengthThatIsYetToBeReadTakesNothingAway) {
  Parameters p = Commanded::every_frame();
  p.scale.known_diameter_m = 2.0;
  Bench bench(p);
  ScaleState& scale = bench.component->state().scale;
  (void)take_reading({.source = ScaleSource::kDiameter, .metres_per_mu = 0.5, .sigma = 0.01}, scale.readings);
  scale.known = true;
  scale.metres_per_mu = 0.5;
  const CommandOctets range = command(
      CommandCode::kSetRange, bus::SetRangeCommand{.frame_timestamp_ns = 7, .range_m = 12.5});
  const std::array<std::span<const std::uint8_t>, 1> commands{range};
  const Picture dark = uniform(0);
  (void)bench.component->step({.frame = frame_of(Bench::kSecond_ns, dark), .commands = commands});
  EXPECT_TRUE(scale.known);
  EXPECT_EQ(scale.metres_per_mu, 0.5);
  EXPECT_EQ(scale.readings.size(), 1U);
}

CommandOctets attitude(std::int64_t time_ns) {
  return command(CommandCode::kServicerAttitude,
                 bus::ServicerAttitudeCommand{.timestamp_ns = time_ns,
                                              .q_IC = {1.0, 0.0, 0.0, 0.0},
                                              .w_C_rad_s = {0.0, 0.01, 0.0}});
}

TEST(Commands, ServicerAttitudeGoesForwardInTimeOnly) {
  Commanded bench;
  EXPECT_EQ(Commanded::housekeeping(bench.step(attitude(100))).commands_accepted, 1U);
  const StepOutput& out = bench.step(attitude(100));
  EXPECT_TRUE(event(EventId::kCommandState, out));
  EXPECT_NE(Commanded::housekeeping(out).flags & bus::housekeeping_layout::kFlagServicerAttitude, 0);
}

TEST(Commands, ServicerAttitudesOutvoteOneOfAWrongTime) {
  Commanded bench;
  (void)bench.step(attitude(1'000'000));
  for (std::int64_t i = 1; i <= 9; ++i) {
    EXPECT_TRUE(event(EventId::kCommandState, bench.step(attitude(i)))) << i;
  }
  EXPECT_FALSE(event(EventId::kCommandState, bench.step(attitude(10))));
  EXPECT_EQ(bench.component->state().bus.servicer.timestamp_ns, 10);
}

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

TEST(ParameterTable, IsLoadedApart_AndSwappedByActivationOnly) {
  Commanded bench;
  const Parameters& active = bench.component->state().parameters;
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
    const StepOutput& out =
        bench.step(bus::table_load(std::vector{entry("features.count_max", std::uint64_t{300}), bad[i]}));
    EXPECT_TRUE(event(EventId::kTableRefused, out)) << i;
    const auto told = Commanded::housekeeping(out);
    EXPECT_EQ(told.commands_rejected, 1U) << i;
    EXPECT_EQ(told.table_entries, 0) << i;
    EXPECT_EQ(told.flags & bus::housekeeping_layout::kFlagTableLoaded, 0) << i;
  }
}

TEST(ParameterTable, IsNotActivatedWithAnotherChecksumOrCount_NorWithoutALoad) {
  Commanded bench;
  const std::vector entries = {entry("features.count_max", std::uint64_t{321})};
  EXPECT_TRUE(event(EventId::kTableNotActivated, bench.step(activation(entries))));
  (void)bench.step(bus::table_load(entries));
  for (const bus::TableActivateCommand& wrong :
       {bus::TableActivateCommand{.crc32 = 1, .entries = 1},
        bus::TableActivateCommand{.crc32 = bench.component->state().bus.inactive.crc, .entries = 2}}) {
    EXPECT_TRUE(event(EventId::kTableNotActivated,
                      bench.step(command(CommandCode::kTableActivate, wrong))));
  }
  EXPECT_NE(bench.component->state().parameters.features.count_max, 321);
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
  EXPECT_FALSE(unplanned.component->state().parameters.mask.background);
}

TEST(ParameterTable, IsForgottenOnDiscard) {
  Commanded bench;
  (void)bench.step(bus::table_load(std::vector{entry("features.count_max", std::uint64_t{321})}));
  EXPECT_EQ(Commanded::housekeeping(bench.step(command(CommandCode::kTableDiscard))).table_entries, 0);
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

/// A million random and mutated packets are the fuzz target's; these go through the whole component.
TEST(Commands, RandomOnesNeverHarmAndAreAllCounted) {
  Commanded bench;
  Rng rng(5, 9);
  const auto seeds = bus::one_of_each();
  std::uint32_t given = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<CommandOctets> commands(1 + rng.below(limits::kStepCommands));
    for (CommandOctets& octets : commands) {
      octets = seeds[rng.below(static_cast<std::uint32_t>(seeds.size()))];
      if (octets[7] == static_cast<std::uint8_t>(CommandCode::kResetCounters)) {
        octets = command(CommandCode::kNoop);
      }
      // Arguments are damaged, and half of the time the checksum is made right again.
      octets[rng.below(static_cast<std::uint32_t>(octets.size()))] = static_cast<std::uint8_t>(rng.below(256));
      const bool reset = octets[7] == static_cast<std::uint8_t>(CommandCode::kResetCounters);
      if (rng.below(2) == 0 && !reset) {
        bus::write_crc(octets);
      }
    }
    given += static_cast<std::uint32_t>(commands.size());
    const std::vector<std::span<const std::uint8_t>> spans(commands.begin(), commands.end());
    execute_commands(spans, &bench.component->state());
    const CommandCounts& counts = bench.component->state().bus.commands;
    ASSERT_EQ(counts.accepted + counts.rejected, given) << round;
    bench.component->state().bus.events.waiting.clear();
  }
  EXPECT_EQ(first_bad_key(bench.component->state().parameters), "");
}

}  // namespace
}  // namespace polhode
