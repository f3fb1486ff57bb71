// What the fuzz target saw.
#pragma once

#include <array>
#include <cstdint>
#include <numeric>

namespace polhode::fuzz {

struct Counts {
  std::uint64_t given = 0;
  std::uint64_t taken = 0;
  std::array<std::uint64_t, 8> refused{};  ///< by reason

  [[nodiscard]] std::uint64_t refused_in_all() const {
    return std::accumulate(refused.begin(), refused.end(), std::uint64_t{0});
  }
};

Counts& counts();

}  // namespace polhode::fuzz
