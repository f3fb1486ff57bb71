#include "transport/command_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <string>

#include "bus/capacities.hpp"
#include "errors.hpp"
#include "input_text.hpp"
#include "transport/command_text.hpp"

namespace polhode::platform {
namespace {

/// The line without its remark and the blanks around it.
std::string_view content_of(std::string_view line) {
  line = line.substr(0, line.find('#'));
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) {
    return {};
  }
  return line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

TimedCommand read_line(std::string_view line, CommandWriter& writer) {
  TimedCommand command;
  const auto end = std::from_chars(line.data(), line.data() + line.size(), command.timestamp_ns);
  const auto used = static_cast<std::size_t>(end.ptr - line.data());
  if (end.ec != std::errc{} || used == line.size() || (line[used] != ' ' && line[used] != ',')) {
    throw UnusableInput("allowed is TIMESTAMP_NS COMMAND [argument=value]...");
  }
  const std::string rest(line.substr(used + 1));
  command.octets = writer.packet(line[used] == ',' ? "hex " + rest : rest);
  return command;
}

}  // namespace

CommandFile::CommandFile(const std::filesystem::path& file, int apid_first) {
  const std::string text = read_text(file, kTableBytesMax);
  CommandWriter writer(apid_first);
  TextLines lines(text);
  for (std::string_view line; lines.next(&line);) {
    const std::string_view content = content_of(line);
    if (content.empty()) {
      continue;
    }
    try {
      commands_.push_back(read_line(content, writer));
    } catch (const UnusableInput& problem) {
      throw UnusableInput(fmt::format("{}:{}: {}", file.string(), lines.number(), problem.what()));
    }
    const std::size_t count = commands_.size();
    if (count > 1 && commands_[count - 1].timestamp_ns < commands_[count - 2].timestamp_ns) {
      throw UnusableInput(fmt::format("{}:{}: time decreases", file.string(), lines.number()));
    }
  }
  handed_.reserve(limits::kStepCommands);
}

std::span<const std::span<const std::uint8_t>> CommandFile::due(std::int64_t frame_timestamp_ns) {
  handed_.clear();
  while (next_ < commands_.size() && handed_.size() < limits::kStepCommands &&
         commands_[next_].timestamp_ns <= frame_timestamp_ns) {
    handed_.emplace_back(commands_[next_++].octets);
  }
  return handed_;
}

}  // namespace polhode::platform
