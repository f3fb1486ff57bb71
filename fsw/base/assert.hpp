// Assertions for our own mistakes. They stay in flight builds and report the offending value.
#pragma once

namespace polhode {

struct AssertionReport {
  const char* expression;
  const char* file;
  int line;
  double value;
};

/// Called when an assertion fails, before the process is aborted. The platform sets one that
/// passes the report on; a service manager then restarts the program.
using AssertionHook = void (*)(const AssertionReport&);
void set_assertion_hook(AssertionHook hook);

[[noreturn]] void assertion_failed(const char* expression,
                                   const char* file,
                                   int line,
                                   double value);

}  // namespace polhode

#define POLHODE_ASSERT(condition, value)                                                       \
  do {                                                                                         \
    if (!(condition)) [[unlikely]] {                                                           \
      ::polhode::assertion_failed(#condition, __FILE__, __LINE__, static_cast<double>(value)); \
    }                                                                                          \
  } while (false)
