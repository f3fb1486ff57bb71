// Commands through a whole component, and what it tells of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "commanded.hpp"
#include "pipeline/checkpoint.hpp"
#include "pipeline/commands.hpp"
#include "pipeline/parameter_image.hpp"
#include "state_of.hpp"

namespace polhode::commands_test {
namespace {

using namespace bench;

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

CommandOctets counted(CommandOctets octets, std::uint16_t sequence) {
  bus::put_u16(octets, 2, static_cast<std::uint16_t>(0xC000U | sequence));
  bus::write_crc(octets);
  return octets;
}

TEST(Commands, ThatComeTwiceWithOneCountAreAnsweredAndNotCarriedOutAgain) {
  Commanded bench;
  const CommandOctets hold = counted(command(CommandCode::kHold), 900);
  const auto first = event(EventId::kCommandAccepted, bench.step(hold));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->command_sequence, 900);
  EXPECT_TRUE(event(EventId::kCommandAccepted, bench.step(command(CommandCode::kResume))));

  const StepOutput& out = bench.step(hold);
  const auto again = event(EventId::kCommandRepeated, out);
  ASSERT_TRUE(again);
  EXPECT_EQ(std::string(again->text.data()), "command 3 hold of count 900 was carried out before");
  EXPECT_EQ(again->command_sequence, 900);
  EXPECT_FALSE(event(EventId::kCommandAccepted, out));
  const auto told = Commanded::housekeeping(out);
  EXPECT_EQ(told.flags & bus::housekeeping_layout::kFlagHeld, 0);
  EXPECT_EQ(told.commands_accepted, 2U);
  EXPECT_EQ(told.commands_rejected, 0U);

  EXPECT_TRUE(event(EventId::kCommandAccepted, bench.step(counted(hold, 901))));
}

TEST(Commands, WithoutACountAreCarriedOutEachTime) {
  Commanded bench;
  const CommandOctets noop = command(CommandCode::kNoop);
  const StepOutput& out = bench.step({noop, noop});
  EXPECT_EQ(Commanded::housekeeping(out).commands_accepted, 2U);
  EXPECT_EQ(event(EventId::kNoop, out)->command_sequence, 0);
}

TEST(Commands, ThatWereRefusedAreLookedAtAnewWhenTheyComeAgain) {
  Commanded bench;
  const CommandOctets resume = counted(command(CommandCode::kResume), 5);
  const auto refused = event(EventId::kCommandState, bench.step(resume));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->command_sequence, 5);
  EXPECT_TRUE(event(EventId::kCommandAccepted, bench.step(command(CommandCode::kHold))));
  EXPECT_TRUE(event(EventId::kCommandAccepted, bench.step(resume)));
}

TEST(Commands, EachAnswerBearsTheCountOfItsOwnCommand) {
  Commanded bench;
  CommandOctets damaged = counted(command(CommandCode::kHold), 12);
  damaged.back() ^= 1;
  const StepOutput& out = bench.step({counted(command(CommandCode::kNoop), 10),
                                      counted(command(static_cast<CommandCode>(200)), 11),
                                      damaged,
                                      counted(command(CommandCode::kCheckpoint), 13)});
  EXPECT_EQ(event(EventId::kNoop, out)->command_sequence, 10);
  EXPECT_EQ(event(EventId::kCommandUnknown, out)->command_sequence, 11);
  EXPECT_EQ(event(EventId::kCommandCrc, out)->command_sequence, 0);  // may be damaged, too
  EXPECT_EQ(event(EventId::kCheckpointAsked, out)->command_sequence, 13);
  EXPECT_EQ(event(EventId::kStarted, out)->command_sequence, 0);
}

TEST(Commands, ThatWereDoneAreKnownAfterARestart) {
  Commanded before;
  const CommandOctets clear = counted(command(CommandCode::kResetMap), 77);
  (void)before.step(clear);
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(*before.component, octets));
  Commanded after;
  ASSERT_TRUE(restore_checkpoint(octets, after.component));
  EXPECT_TRUE(event(EventId::kCommandRepeated, after.step(clear)));
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

// verifies: CMD-01
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

// verifies: CMD-03
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
  const Component::State& state = state_of(*bench.component);
  ASSERT_FALSE(state.initialisation.tracks.frames.empty());
  (void)bench.step(command(CommandCode::kHold));
  EXPECT_TRUE(state.initialisation.tracks.frames.empty());
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
  const ScaleOptions& scale = state_of(*bench.component).configuration.parameters.scale;
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
  const StepOutput& out =
      bench.component->step({.frame = frame_of(Bench::kSecond_ns, dark), .commands = commands});
  const Parameters& now = state_of(*bench.component).configuration.parameters;
  EXPECT_EQ(now.scale.range_m, 12.5);
  EXPECT_EQ(now.scale.known_diameter_m, 2.0);
  EXPECT_EQ(now.scale.range_sigma_m, 0.05);
  EXPECT_EQ(Commanded::housekeeping(out).table_crc, table_crc(now));
}

TEST(Commands, ALengthThatIsYetToBeReadTakesNothingAway) {
  Parameters p = Commanded::every_frame();
  p.scale.known_diameter_m = 2.0;
  Bench bench(p);
  ScaleState& scale = state_of(*bench.component).scale;
  (void)add_reading({.source = ScaleSource::kDiameter, .metres_per_mu = 0.5, .sigma = 0.01},
                    scale.readings);
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
  return command(
      CommandCode::kServicerAttitude,
      bus::ServicerAttitudeCommand{
          .timestamp_ns = time_ns, .q_IC = {1.0, 0.0, 0.0, 0.0}, .w_C_rad_s = {0.0, 0.01, 0.0}});
}

TEST(Commands, ServicerAttitudeGoesForwardInTimeOnly) {
  Commanded bench;
  EXPECT_EQ(Commanded::housekeeping(bench.step(attitude(100))).commands_accepted, 1U);
  const StepOutput& out = bench.step(attitude(100));
  EXPECT_TRUE(event(EventId::kCommandState, out));
  EXPECT_NE(Commanded::housekeeping(out).flags & bus::housekeeping_layout::kFlagServicerAttitude,
            0);
}

TEST(Commands, ServicerAttitudesOutvoteOneOfAWrongTime) {
  Commanded bench;
  (void)bench.step(attitude(1'000'000));
  for (std::int64_t i = 1; i <= 9; ++i) {
    EXPECT_TRUE(event(EventId::kCommandState, bench.step(attitude(i)))) << i;
  }
  EXPECT_FALSE(event(EventId::kCommandState, bench.step(attitude(10))));
  EXPECT_EQ(state_of(*bench.component).bus.servicer.timestamp_ns, 10);
}

std::uint32_t occurrences(EventId id, const bus::EventLog& log) {
  const auto row = std::find_if(
      bus::kEvents.begin(), bus::kEvents.end(), [id](const auto& known) { return known.id == id; });
  return log.counts[static_cast<std::size_t>(row - bus::kEvents.begin())].occurrences;
}

/// A million random and mutated packets are the fuzz target's; these go through the whole
/// component.
// verifies: CMD-02
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
      octets[rng.below(static_cast<std::uint32_t>(octets.size()))] =
          static_cast<std::uint8_t>(rng.below(256));
      const bool reset = octets[7] == static_cast<std::uint8_t>(CommandCode::kResetCounters);
      if (rng.below(2) == 0 && !reset) {
        bus::write_crc(octets);
      }
    }
    given += static_cast<std::uint32_t>(commands.size());
    const std::vector<std::span<const std::uint8_t>> spans(commands.begin(), commands.end());
    execute_commands(spans, &state_of(*bench.component));
    const BusState& bus = state_of(*bench.component).bus;
    const std::uint32_t repeated = occurrences(EventId::kCommandRepeated, bus.events);
    ASSERT_EQ(bus.commands.accepted + bus.commands.rejected + repeated, given) << round;
    state_of(*bench.component).bus.events.waiting.clear();
  }
  EXPECT_EQ(first_bad_key(state_of(*bench.component).configuration.parameters), "");
}

}  // namespace
}  // namespace polhode::commands_test
