#include "bus/commands.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/rng.hpp"
#include "command_packets.hpp"

namespace polhode::bus::commands_test {
namespace {

constexpr int kApidFirst = 0x1A0;

Rejection verdict(const CommandOctets& octets) {
  Command out;
  return read_command(octets, kApidFirst, &out).reason;
}

TEST(Command, OfEachCodeIsRead_WithItsArguments) {
  const auto commands = one_of_each();
  ASSERT_EQ(commands.size(), command_layouts().size());
  for (std::size_t code = 0; code < commands.size(); ++code) {
    Command read;
    ASSERT_EQ(read_command(commands[code], kApidFirst, &read).reason, Rejection::kNone) << code;
    EXPECT_EQ(static_cast<std::size_t>(read.code), code);
  }
  Command read;
  (void)read_command(commands[5], kApidFirst, &read);
  const auto length = read.arguments<SetKnownLengthCommand>();
  EXPECT_EQ(length.length_m, 0.6);
  EXPECT_EQ(length.second_px, (std::array<double, 2>{30.0, 40.0}));
  (void)read_command(commands[9], kApidFirst, &read);
  ASSERT_EQ(read.entries, 1U);
  EXPECT_EQ(read.entry(0).value, 2U);
}

TEST(Command, OfAnyOtherLengthIsRefused) {
  for (const CommandOctets& good : one_of_each()) {
    for (std::size_t size = 0; size < good.size(); ++size) {
      EXPECT_EQ(
          verdict(CommandOctets(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))),
          Rejection::kLength);
    }
    // The header may agree with the datagram: the command's own length decides.
    CommandOctets longer = good;
    longer.resize(good.size() + 2);
    seal(static_cast<CommandCode>(good[7]), &longer);
    EXPECT_EQ(verdict(longer), Rejection::kLength) << static_cast<int>(good[7]);
    CommandOctets shorter(good.begin(), good.end() - 1);
    seal(static_cast<CommandCode>(good[7]), &shorter);
    EXPECT_EQ(verdict(shorter), Rejection::kLength) << static_cast<int>(good[7]);
  }
  EXPECT_EQ(verdict(CommandOctets(2000)), Rejection::kLength);
}

TEST(Command, WithAnyOneBitFlippedIsRefused_ButForItsCount) {
  for (CommandOctets octets : one_of_each()) {
    for (std::size_t bit = 0; bit < 8 * octets.size(); ++bit) {
      octets[bit / 8] = static_cast<std::uint8_t>(octets[bit / 8] ^ (1U << (bit % 8)));
      EXPECT_NE(verdict(octets), Rejection::kNone) << bit;
      octets[bit / 8] = static_cast<std::uint8_t>(octets[bit / 8] ^ (1U << (bit % 8)));
    }
  }
}

TEST(Command, OfAnotherApidTypeOrLayoutIsRefused) {
  CommandOctets octets = command(CommandCode::kNoop);
  seal(CommandCode::kNoop, &octets, kApidFirst + 1);
  EXPECT_EQ(verdict(octets), Rejection::kHeader);
  octets = command(CommandCode::kNoop);
  octets[0] &= 0xEF;  // telemetry
  write_crc(octets);
  EXPECT_EQ(verdict(octets), Rejection::kHeader);
  octets = command(CommandCode::kNoop);
  octets[6] = kLayoutVersion + 1;
  write_crc(octets);
  EXPECT_EQ(verdict(octets), Rejection::kHeader);
}

TEST(Command, OfAnUnknownCodeIsRefused_AndNamed) {
  for (int code = static_cast<int>(command_layouts().size()); code < 256; ++code) {
    Command read;
    const Refusal refusal =
        read_command(command(static_cast<CommandCode>(code)), kApidFirst, &read);
    EXPECT_EQ(refusal.reason, Rejection::kUnknownCode);
    EXPECT_EQ(refusal.code, code);
  }
}

TEST(Command, WithAnArgumentOutOfRangeIsRefused_AndTheArgumentNamed) {
  const auto refused = [](CommandCode code, const auto& arguments) {
    const CommandOctets octets = command(code, arguments);
    Command read;
    const Refusal refusal = read_command(octets, kApidFirst, &read);
    EXPECT_EQ(refusal.reason, Rejection::kRange);
    return std::string(refusal.why);
  };
  const double nan = std::nan("");
  for (const double bad : {0.0, -1.0, 1e9, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(
        refused(CommandCode::kSetRange, SetRangeCommand{.frame_timestamp_ns = 1, .range_m = bad}),
        "range_m");
  }
  EXPECT_EQ(
      refused(CommandCode::kSetRange, SetRangeCommand{.frame_timestamp_ns = -1, .range_m = 5.0}),
      "frame_timestamp_ns");
  EXPECT_EQ(refused(CommandCode::kRequestCloud, RequestCloudCommand{.points_max = 0}),
            "points_max");
  EXPECT_EQ(refused(CommandCode::kServicerAttitude,
                    ServicerAttitudeCommand{.q_IC = {0.5, 0.5, 0.5, 0.4}}),
            "q_IC");
  EXPECT_EQ(
      refused(CommandCode::kServicerAttitude,
              ServicerAttitudeCommand{.q_IC = {1.0, 0.0, 0.0, 0.0}, .w_C_rad_s = {0.0, nan, 0.0}}),
      "w_C_rad_s");
  EXPECT_EQ(refused(CommandCode::kSetKnownLength,
                    SetKnownLengthCommand{
                        .length_m = 1.0, .first_px = {5.0, 5.0}, .second_px = {5.0, 5.0}}),
            "second_px");
}

TEST(TableLoad, IsAsLongAsItsEntriesSay_AndNoLonger) {
  std::vector<TableLoadEntry> entries(kTableLoadEntriesMax);
  EXPECT_EQ(verdict(table_load(entries)), Rejection::kNone);
  EXPECT_LE(table_load(entries).size(), limits::kPacketOctets);
  entries.resize(kTableLoadEntriesMax + 1);
  EXPECT_EQ(verdict(table_load(entries)), Rejection::kRange);
  EXPECT_EQ(verdict(table_load({})), Rejection::kRange);
  entries.resize(3);
  CommandOctets octets = table_load(entries);
  put_u16(octets, table_load_layout::kEntries, 2);
  write_crc(octets);
  EXPECT_EQ(verdict(octets), Rejection::kLength);
  put_u16(octets, table_load_layout::kEntries, 0xFFFF);
  write_crc(octets);
  EXPECT_EQ(verdict(octets), Rejection::kLength);
}

TEST(TableLoad, WithAnEntryOutOfRangeIsRefused) {
  std::vector<TableLoadEntry> entries(3);
  entries[2].index = 4;
  EXPECT_EQ(verdict(table_load(entries)), Rejection::kRange);
  entries[2] = {.spare = 1};
  EXPECT_EQ(verdict(table_load(entries)), Rejection::kRange);
}

/// Random and mutated octets: none is taken but those whose CRC and content happen to be right,
/// which the reference says by itself.
TEST(Command, RandomAndMutatedOctetsAreNeverTakenForOne) {
  const auto seeds = one_of_each();
  Rng rng(7, 3);
  for (int i = 0; i < 200'000; ++i) {
    CommandOctets octets = seeds[rng.below(static_cast<std::uint32_t>(seeds.size()))];
    const CommandOctets original = octets;
    const std::uint32_t changes = 1 + rng.below(4);
    for (std::uint32_t change = 0; change < changes; ++change) {
      octets[rng.below(static_cast<std::uint32_t>(octets.size()))] =
          static_cast<std::uint8_t>(rng.below(256));
    }
    // Four octets of change can cancel in a CRC of 16 bits, one time in 65536: then the CRC
    // vouches.
    if (octets != original && !crc_is_right(octets)) {
      ASSERT_NE(verdict(octets), Rejection::kNone) << i;
    }
  }
}

}  // namespace
}  // namespace polhode::bus::commands_test
