// Counter-based random numbers: the n-th number of a stream is a pure function of (seed, stream,
// n), so a sampler's draws depend on nothing that ran before it.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/assert.hpp"

namespace polhode {

/// SplitMix64 finaliser over a counter (Steele, Lea, Flood, OOPSLA 2014). Its constants are the
/// paper's; the stream's offset is another odd number, so that seed and stream do not cancel.
class Rng {
 public:
  Rng(std::uint64_t seed, std::uint64_t stream)
      : state_(mix(seed + 0x9E3779B97F4A7C15ULL) ^ mix(stream + 0xD1B54A32D192ED03ULL)) {}

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    return mix(state_);
  }

  /// Uniform integer in [0, bound), bound >= 1, by multiplication (bias below 2^-32 for bound <
  /// 2^32).
  std::uint32_t below(std::uint32_t bound) {
    POLHODE_ASSERT(bound >= 1, bound);
    return static_cast<std::uint32_t>(((next() >> 32U) * bound) >> 32U);
  }

  /// Uniform in [0, 1): 53 bits, the mantissa of a double.
  double uniform() { return static_cast<double>(next() >> 11U) * 0x1.0p-53; }

  /// Standard normal (Box-Muller, one of the pair).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
};

}  // namespace polhode
