#include "os/linux/assertion.hpp"

#include "os/linux/last_words.hpp"

namespace polhode::platform {

void tell_assertion(const AssertionReport& report) {
  tell_last("polhode: %s:%d: assertion failed: %s (%.17g); the run ends here\n",
            report.file,
            report.line,
            report.expression,
            report.value);
}

void tell_assertions() { set_assertion_hook(tell_assertion); }

}  // namespace polhode::platform
