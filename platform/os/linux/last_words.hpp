// A last message on stderr when the program has to end.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <cstddef>
#include <cstdio>

namespace polhode::platform {

/// One line to stderr, by printf's rules, cut after 400 bytes. Takes no memory.
[[gnu::format(printf, 1, 2)]] inline void print_last(const char* format, ...) {
  char text[400];
  std::va_list values;
  va_start(values, format);
  const int wanted = std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  const auto length =
      static_cast<std::size_t>(std::clamp(wanted, 0, static_cast<int>(sizeof text) - 1));
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, length);
}

}  // namespace polhode::platform
