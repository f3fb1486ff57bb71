#include "bus/repeated_commands.hpp"

#include <gtest/gtest.h>

#include "command_packets.hpp"

namespace polhode::bus {
namespace {

CommandOctets counted(CommandCode code, std::uint16_t sequence) {
  CommandOctets octets = command(code);
  put_u16(octets, 2, static_cast<std::uint16_t>(0xC000U | sequence));
  write_crc(octets);
  return octets;
}

TEST(RepeatedCommands, AreKnownByTheirCountAndAllTheirOctets) {
  CommandsDone done;
  const CommandOctets hold = counted(CommandCode::kHold, 7);
  EXPECT_FALSE(was_done(hold, 10, done));
  remember(hold, 10, &done);
  EXPECT_TRUE(was_done(hold, 11, done));
  EXPECT_FALSE(was_done(counted(CommandCode::kHold, 8), 11, done));
  EXPECT_FALSE(was_done(counted(CommandCode::kResume, 7), 11, done));
}

TEST(RepeatedCommands, WithoutACountAreNeverKnown) {
  CommandsDone done;
  const CommandOctets hold = counted(CommandCode::kHold, 0);
  remember(hold, 10, &done);
  EXPECT_FALSE(was_done(hold, 10, done));
  EXPECT_EQ(done.crc, CommandsDone{}.crc);
}

TEST(RepeatedCommands, AreForgottenByLaterOnesAndByTime) {
  CommandsDone done;
  const auto first = static_cast<std::uint16_t>(1);
  for (std::uint16_t i = first; i <= limits::kCommandsRemembered; ++i) {
    remember(counted(CommandCode::kNoop, i), 5, &done);
  }
  EXPECT_TRUE(was_done(counted(CommandCode::kNoop, first), 5, done));
  remember(counted(CommandCode::kNoop, limits::kCommandsRemembered + 1), 5, &done);
  EXPECT_FALSE(was_done(counted(CommandCode::kNoop, first), 5, done));

  const CommandOctets last = counted(CommandCode::kNoop, limits::kCommandsRemembered + 1);
  EXPECT_TRUE(was_done(last, 5 + limits::kRepeatFrames, done));
  EXPECT_FALSE(was_done(last, 6 + limits::kRepeatFrames, done));
  // A later command does not bring the forgotten ones back.
  remember(counted(CommandCode::kHold, 1), 6 + limits::kRepeatFrames, &done);
  EXPECT_FALSE(was_done(last, 6 + limits::kRepeatFrames, done));
}

TEST(RepeatedCommands, AreKnownWhereTheFrameIndexWraps) {
  CommandsDone done;
  const CommandOctets hold = counted(CommandCode::kHold, 7);
  remember(hold, 0xFFFFFFFFU, &done);
  EXPECT_TRUE(was_done(hold, 3, done));
}

TEST(CommandSequence, CountsFromOneAndWrapsPastZero) {
  EXPECT_EQ(command_sequence(counted(CommandCode::kNoop, 16383)), 16383);
  EXPECT_EQ(command_sequence(counted(CommandCode::kNoop, 0)), 0);
  EXPECT_EQ(next_command_sequence(1), 2);
  EXPECT_EQ(next_command_sequence(16383), 1);
}

}  // namespace
}  // namespace polhode::bus
