// The two ways in which a command ends badly. Thrown at start and at the end only, never while
// frames are stepped.
#pragma once

#include <stdexcept>
#include <string>

#include "quote.hpp"

namespace polhode::platform {

/// Unusable arguments, configuration or input, found before anything started: exit status 2.
struct UnusableInput : std::runtime_error {
  explicit UnusableInput(const std::string& what) : std::runtime_error(legible(what)) {}
};

/// The run itself failed: exit status 1.
struct RunFailure : std::runtime_error {
  explicit RunFailure(const std::string& what) : std::runtime_error(legible(what)) {}
};

}  // namespace polhode::platform
