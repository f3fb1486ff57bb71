#include "base/assert.hpp"

#include <cstdlib>

namespace polhode {
namespace {
AssertionHook g_hook = nullptr;  // set once at start by the platform, read only afterwards
}

void set_assertion_hook(AssertionHook hook) { g_hook = hook; }

void assertion_failed(const char* expression, const char* file, int line, double value) {
  if (g_hook != nullptr) {
    g_hook(AssertionReport{.expression = expression, .file = file, .line = line, .value = value});
  }
  std::abort();
}

}  // namespace polhode
