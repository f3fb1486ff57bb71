#include "transport/command_text.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "base/crc.hpp"
#include "bus/commands.hpp"
#include "errors.hpp"
#include "packets.hpp"
#include "pipeline/parameter_image.hpp"
#include "transport/command_file.hpp"

namespace polhode::platform::command_text_test {
namespace {

constexpr int kApidFirst = 0x1A0;

/// The command that a line makes, as the component reads it.
struct Read {
  explicit Read(const std::string& line) : Read(line, writer_of_its_own()) {}
  Read(const std::string& line, CommandWriter& writer) : octets(writer.packet(line)) {
    reason = bus::read_command(octets, kApidFirst, &command).reason;
  }
  static CommandWriter& writer_of_its_own() {
    static CommandWriter writer(kApidFirst);
    return writer;
  }
  Octets octets;
  bus::Command command;
  bus::Rejection reason = bus::Rejection::kNone;
};

TEST(CommandText, MakesPacketsThatAreTaken) {
  EXPECT_EQ(Read("noop").reason, bus::Rejection::kNone);
  const Read range("set_range  range_m=12.5 frame_timestamp_ns=1700000000000000001");
  ASSERT_EQ(range.reason, bus::Rejection::kNone);
  EXPECT_EQ(range.command.arguments<bus::SetRangeCommand>().range_m, 12.5);
  EXPECT_EQ(range.command.arguments<bus::SetRangeCommand>().frame_timestamp_ns,
            1700000000000000001);
  const Read attitude("servicer_attitude timestamp_ns=5 q_IC=1,0,0,0 w_C_rad_s=0,0.01,-0.02");
  ASSERT_EQ(attitude.reason, bus::Rejection::kNone);
  EXPECT_EQ(attitude.command.arguments<bus::ServicerAttitudeCommand>().w_C_rad_s[2], -0.02);
}

TEST(CommandText, LeavesRangesToTheReceiver) {
  EXPECT_EQ(Read("set_range range_m=-1 frame_timestamp_ns=0").reason, bus::Rejection::kRange);
  EXPECT_EQ(Read("hex 19AFC00000030300").reason, bus::Rejection::kLength);
}

TEST(CommandText, LoadsParametersByKey_AndKnowsTheirChecksum) {
  CommandWriter writer(kApidFirst);
  const Read load("table_load features.count_max=500 mask.enabled=false features.sigma_px=0.3",
                  writer);
  ASSERT_EQ(load.reason, bus::Rejection::kNone);
  ASSERT_EQ(load.command.entries, 3U);
  EXPECT_EQ(load.command.entry(0).key_crc, key_crc("features.count_max"));
  EXPECT_EQ(load.command.entry(0).value, 500U);
  EXPECT_EQ(load.command.entry(1).value, 0U);
  const Read activate("table_activate", writer);
  const auto reported = activate.command.arguments<bus::TableActivateCommand>();
  EXPECT_EQ(reported.crc32, crc32_iso_hdlc(load.command.entry_octets()));
  EXPECT_EQ(reported.entries, 3U);
}

TEST(CommandText, ThatMakesNoSenseIsRefused) {
  CommandWriter writer(kApidFirst);
  for (const char* line : {"",
                           "dance",
                           "noop now=1",
                           "set_range range_m=1",
                           "set_range range_m=1 range_m=2 frame_timestamp_ns=0",
                           "set_range range_m=x frame_timestamp_ns=0",
                           "set_range range_m=1 frame_timestamp_ns=1.5",
                           "servicer_attitude timestamp_ns=5 q_IC=1,0,0 w_C_rad_s=0,0,0",
                           "request_cloud points_max=-1",
                           "request_cloud points_max=4294967296",
                           "table_load",
                           "table_load features.count_maximum=5",
                           "table_load features.count_max=many",
                           "hex 123",
                           "hex zz"}) {
    EXPECT_THROW(writer.packet(line), UnusableInput) << line;
  }
}

CommandFile file_of(const Folder& folder, const std::string& text) {
  std::ofstream(folder / "commands.txt") << text;
  return {folder / "commands.txt", kApidFirst};
}

TEST(CommandFile, HandsCommandsOverWithTheFirstFrameOfTheirTimeOrLater) {
  const Folder folder;
  CommandFile file = file_of(folder, "# flight 3\n100 noop\n\n  200 hold  # wait\n200 resume\n");
  EXPECT_EQ(file.size(), 3U);
  EXPECT_TRUE(file.due(99).empty());
  EXPECT_EQ(file.due(150).size(), 1U);
  EXPECT_TRUE(file.due(150).empty());
  EXPECT_EQ(file.due(1000).size(), 2U);
  EXPECT_EQ(file.left(), 0U);
}

TEST(CommandFile, TakesWhatARecordingExports) {
  const Folder folder;
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (const std::uint8_t octet : Read("noop").octets) {
    hex += {kDigits[octet >> 4], kDigits[octet & 0xF]};
  }
  CommandFile file = file_of(folder, "#timestamp [ns],packet\n100," + hex + "\n");
  ASSERT_EQ(file.size(), 1U);
  const auto handed = file.due(100);
  bus::Command command;
  EXPECT_EQ(bus::read_command(handed[0], kApidFirst, &command).reason, bus::Rejection::kNone);
}

TEST(CommandFile, HandsOverNoMoreAtOnceThanAStepTakes) {
  const Folder folder;
  std::string text;
  for (std::size_t i = 0; i < limits::kStepCommands + 3; ++i) {
    text += "5 noop\n";
  }
  CommandFile file = file_of(folder, text);
  EXPECT_EQ(file.due(5).size(), limits::kStepCommands);
  EXPECT_EQ(file.due(6).size(), 3U);
}

TEST(CommandFile, ThatIsWrongIsRefusedByItsLine) {
  const Folder folder;
  for (const char* text :
       {"1 noop\n2 dance\n", "1 noop\nnoop\n", "2 noop\n1 noop\n", "1 noop\n2\n"}) {
    try {
      (void)file_of(folder, text);
      ADD_FAILURE() << text;
    } catch (const UnusableInput& problem) {
      EXPECT_NE(std::string(problem.what()).find("commands.txt:2"), std::string::npos)
          << problem.what();
    }
  }
  EXPECT_THROW(CommandFile(folder / "missing", kApidFirst), UnusableInput);
}

}  // namespace
}  // namespace polhode::platform::command_text_test
