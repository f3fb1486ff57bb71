// Text of a file: all of it, or one line with the reason why not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace polhode::platform {

/// A table of ten million frames.
inline constexpr std::size_t kTableBytesMax = std::size_t{1} << 29U;
/// A configuration, a sensor.yaml: far larger than any.
inline constexpr std::size_t kSettingsBytesMax = std::size_t{1} << 20U;

/// Never waits: a FIFO, a device or a folder is refused. A byte-order mark is passed over.
/// @throws UnusableInput naming the file: it cannot be read, is no regular file, is larger than
/// `bytes_max`, or is UTF-16; RunFailure where the machine is at fault, as fail_at_start() has it.
std::string read_text(const std::filesystem::path& file, std::size_t bytes_max);

/// Is there nothing of this name? A link that leads nowhere, and a file that may not be read, count
/// as something.
bool is_absent(const std::filesystem::path& file);

/// The lines of a text; each ends with a line feed, a carriage return, or both.
class TextLines {
 public:
  explicit TextLines(std::string_view text) : rest_(text) {}
  /// @return false at the end.
  bool next(std::string_view* line);
  /// Of the last line, from 1.
  [[nodiscard]] int number() const { return number_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

}  // namespace polhode::platform
