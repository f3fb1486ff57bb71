#include "os/linux/assertion.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "base/assert.hpp"

namespace polhode::platform {
namespace {

void tell(const AssertionReport& report) {
  char text[400];
  const int wanted = std::snprintf(text,
                                   sizeof text,
                                   "polhode: %s:%d: assertion failed: %s (%.17g); the run ends here\n",
                                   report.file,
                                   report.line,
                                   report.expression,
                                   report.value);
  const auto length = static_cast<std::size_t>(std::clamp(wanted, 0, static_cast<int>(sizeof text) - 1));
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, length);
}

}  // namespace

void tell_assertions() { set_assertion_hook(tell); }

}  // namespace polhode::platform
