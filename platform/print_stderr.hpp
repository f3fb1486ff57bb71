// Prints lines on standard error.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

namespace polhode::platform {

/// As fmt::print(stderr, ...), but a failed write ends no run: standard error may be
/// closed, or on a full disk.
template <typename... Values>
void print_stderr(fmt::format_string<Values...> format, Values&&... values) {
  const std::string line = fmt::format(format, std::forward<Values>(values)...);
  (void)std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace polhode::platform
