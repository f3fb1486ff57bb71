#include "os/linux/assertion.hpp"

#include "base/assert.hpp"
#include "os/linux/last_words.hpp"

namespace polhode::platform {
namespace {

void tell(const AssertionReport& report) {
  tell_last("polhode: %s:%d: assertion failed: %s (%.17g); the run ends here\n",
            report.file,
            report.line,
            report.expression,
            report.value);
}

}  // namespace

void tell_assertions() { set_assertion_hook(tell); }

}  // namespace polhode::platform
