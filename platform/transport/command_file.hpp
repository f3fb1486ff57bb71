// Commands with the times at which they are handed over: with frames and configuration they
// determine the bytes of a replay.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace polhode::platform {

struct TimedCommand {
  std::int64_t timestamp_ns = 0;
  std::vector<std::uint8_t> octets;
};

/// A line each: `TIMESTAMP_NS COMMAND`, the command as CommandWriter takes it, or
/// `TIMESTAMP_NS,HEX` as a recording's export writes it; times not decreasing; empty lines and what
/// follows a # are passed over.
class CommandFile {
 public:
  /// No commands.
  CommandFile() = default;
  /// @throws UnusableInput naming file and line.
  CommandFile(const std::filesystem::path& file, int apid_first);

  /// The commands that go with a frame of this time: those of this time and before that were not
  /// handed over yet, at most limits::kStepCommands; the others go with the next frames.
  /// @return valid until the next call.
  std::span<const std::span<const std::uint8_t>> due(std::int64_t frame_timestamp_ns);

  [[nodiscard]] std::size_t size() const { return commands_.size(); }
  [[nodiscard]] std::size_t left() const { return commands_.size() - next_; }

 private:
  std::vector<TimedCommand> commands_;
  std::vector<std::span<const std::uint8_t>> handed_;
  std::size_t next_ = 0;
};

}  // namespace polhode::platform
