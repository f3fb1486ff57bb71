// The two ways in which a command ends badly. Thrown at start and at the end only, never while
// frames are stepped.
//
// A service manager starts again after a failed run, and not after unusable input
// (RestartPreventExitStatus). So what may pass by itself is a failed run.
#pragma once

#include <stdexcept>
#include <string>

#include "quote.hpp"

namespace polhode::platform {

/// Unusable arguments, configuration or input, found before anything started: exit status 2.
/// Starting again changes nothing.
struct UnusableInput : std::runtime_error {
  explicit UnusableInput(const std::string& what) : std::runtime_error(legible(what)) {}
};

/// The run itself failed, or the machine or another process is in its way: exit status 1.
struct RunFailure : std::runtime_error {
  explicit RunFailure(const std::string& what) : std::runtime_error(legible(what)) {}
};

/// What the call returns. What it throws of these two keeps its kind, with `where` before its
/// words.
template <typename Call>
auto named(const std::string& where, Call call) {
  try {
    return call();
  } catch (const UnusableInput& problem) {
    throw UnusableInput(where + ": " + problem.what());
  } catch (const RunFailure& problem) {
    throw RunFailure(where + ": " + problem.what());
  }
}

}  // namespace polhode::platform
