#include "os/linux/assertion.hpp"

#include "os/linux/last_words.hpp"

namespace polhode::platform {

void print_assertion(const AssertionReport& report) {
  print_last("polhode: %s:%d: assertion failed: %s (%.17g); the run ends here\n",
             report.file,
             report.line,
             report.expression,
             report.value);
}

void print_assertions() { set_assertion_hook(print_assertion); }

}  // namespace polhode::platform
