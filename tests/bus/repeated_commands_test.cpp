#include "bus/repeated_commands.hpp"

#include <gtest/gtest.h>

#include "command_packets.hpp"

namespace polhode::bus::repeated_commands_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

CommandOctets counted(CommandCode code, std::uint16_t sequence) {
  CommandOctets octets = command(code);
  put_u16(octets, 2, static_cast<std::uint16_t>(0xC000U | sequence));
  write_crc(octets);
  return octets;
}

TEST(RepeatedCommands, AreKnownByTheirCountAndAllTheirOctets) {
  CommandsDone done;
  const CommandOctets hold = counted(CommandCode::kHold, 7);
  EXPECT_FALSE(was_done(hold, 10 * kSecond_ns, done));
  remember(hold, 10 * kSecond_ns, &done);
  EXPECT_TRUE(was_done(hold, 11 * kSecond_ns, done));
  EXPECT_FALSE(was_done(counted(CommandCode::kHold, 8), 11 * kSecond_ns, done));
  EXPECT_FALSE(was_done(counted(CommandCode::kResume, 7), 11 * kSecond_ns, done));
}

TEST(RepeatedCommands, WithoutACountAreNeverKnown) {
  CommandsDone done;
  const CommandOctets hold = counted(CommandCode::kHold, 0);
  remember(hold, 10 * kSecond_ns, &done);
  EXPECT_FALSE(was_done(hold, 10 * kSecond_ns, done));
  EXPECT_EQ(done.crc, CommandsDone{}.crc);
}

TEST(RepeatedCommands, AreForgottenByLaterOnesAndByTime) {
  CommandsDone done;
  const auto first = static_cast<std::uint16_t>(1);
  for (std::uint16_t i = first; i <= limits::kCommandsRemembered; ++i) {
    remember(counted(CommandCode::kNoop, i), 5 * kSecond_ns, &done);
  }
  EXPECT_TRUE(was_done(counted(CommandCode::kNoop, first), 5 * kSecond_ns, done));
  remember(counted(CommandCode::kNoop, limits::kCommandsRemembered + 1), 5 * kSecond_ns, &done);
  EXPECT_FALSE(was_done(counted(CommandCode::kNoop, first), 5 * kSecond_ns, done));

  const CommandOctets last = counted(CommandCode::kNoop, limits::kCommandsRemembered + 1);
  constexpr std::int64_t kEnd_ns = (5 + limits::kRepeat_s) * kSecond_ns;
  EXPECT_TRUE(was_done(last, kEnd_ns, done));
  EXPECT_FALSE(was_done(last, kEnd_ns + kSecond_ns, done));
  // A later command does not bring the forgotten ones back.
  remember(counted(CommandCode::kHold, 1), kEnd_ns + kSecond_ns, &done);
  EXPECT_FALSE(was_done(last, kEnd_ns + kSecond_ns, done));
}

TEST(RepeatedCommands, AreKnownWhereTimeIsNegative_WasSetBack_AndWhereSecondsWrap) {
  const CommandOctets hold = counted(CommandCode::kHold, 7);
  for (const std::int64_t time_ns : {-kSecond_ns / 2, std::int64_t{0xFFFFFFFF} * kSecond_ns}) {
    CommandsDone done;
    remember(hold, time_ns, &done);
    EXPECT_TRUE(was_done(hold, time_ns + 3 * kSecond_ns, done));
    EXPECT_TRUE(was_done(hold, time_ns - 3 * kSecond_ns, done));
    EXPECT_FALSE(was_done(hold, time_ns + 100 * kSecond_ns, done));
    EXPECT_FALSE(was_done(hold, time_ns - 100 * kSecond_ns, done));
  }
}

TEST(CommandSequence, OfAnAnswerIsThatOfWholeOctetsAlone) {
  CommandOctets octets = counted(CommandCode::kNoop, 9);
  EXPECT_EQ(answered_sequence(octets), 9);
  EXPECT_EQ(answered_sequence(std::span(octets).first(5)), 0);
  EXPECT_EQ(answered_sequence({}), 0);
  octets.back() ^= 1;
  EXPECT_EQ(answered_sequence(octets), 0);
}

TEST(CommandSequence, CountsFromOneAndWrapsPastZero) {
  EXPECT_EQ(command_sequence(counted(CommandCode::kNoop, 16383)), 16383);
  EXPECT_EQ(command_sequence(counted(CommandCode::kNoop, 0)), 0);
  EXPECT_EQ(next_command_sequence(1), 2);
  EXPECT_EQ(next_command_sequence(16383), 1);
}

}  // namespace
}  // namespace polhode::bus::repeated_commands_test
