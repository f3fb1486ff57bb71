// The two ways in which a command ends badly. Thrown at start and at the end only, never while
// frames are stepped.
#pragma once

#include <stdexcept>

namespace polhode::platform {

/// Unusable arguments, configuration or input, found before anything started: exit status 2.
struct UnusableInput : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The run itself failed: exit status 1.
struct RunFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace polhode::platform
