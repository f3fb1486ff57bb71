#include "input_text.hpp"

#include <algorithm>
#include <system_error>

#include "camera/replay/file_bytes.hpp"
#include "errors.hpp"

namespace polhode::platform {

std::string read_text(const std::filesystem::path& file, std::size_t bytes_max) {
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  std::vector<std::uint8_t> bytes;
  read_file_at_start(file, file.string(), bytes, bytes_max);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw UnusableInput(file.string() + ": is UTF-16; allowed is UTF-8");
  }
  return std::string(text.substr(text.starts_with(kUtf8Mark) ? kUtf8Mark.size() : 0));
}

bool is_absent(const std::filesystem::path& file) {
  std::error_code problem;
  return std::filesystem::symlink_status(file, problem).type() ==
         std::filesystem::file_type::not_found;
}

bool TextLines::next(std::string_view* line) {
  if (rest_.empty()) {
    return false;
  }
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  *line = rest_.substr(0, end);
  const bool both = rest_.substr(end, 2) == "\r\n";
  rest_.remove_prefix(std::min(end + (both ? 2 : 1), rest_.size()));
  ++number_;
  return true;
}

}  // namespace polhode::platform
