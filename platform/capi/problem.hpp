// A problem's text in the caller's memory, and the wall that no exception passes.
#pragma once

#include <cstddef>
#include <string_view>

#include "capi/polhode.h"

namespace polhode::capi {

inline void write_problem(std::string_view text, char* problem, std::size_t bytes) noexcept {
  if (problem != nullptr && bytes > 0) {
    const std::size_t length = text.copy(problem, bytes - 1);
    problem[length] = '\0';
  }
}

/// Exceptions of the libraries end here.
template <typename Work>
polhode_status guarded(Work work) noexcept {
  try {
    return work();
  } catch (...) {
    return POLHODE_FAILED;
  }
}

}  // namespace polhode::capi
