// Reports a failed assertion of the component on stderr.
#pragma once

#include "base/assert.hpp"

namespace polhode::platform {

/// From now on the place, the expression and the value go to stderr before the process is aborted.
/// Takes no memory.
void print_assertions();

/// Prints the report.
void print_assertion(const AssertionReport& report);

}  // namespace polhode::platform
