#include "shape/scale_fusion.hpp"

#include <bit>
#include <cmath>
#include <cstdint>

namespace polhode {
namespace {

// Largest difference of two readings, in sigmas. Two-sided normal: 1 in 2150 pairs is farther apart
// by chance (decision 0055).
constexpr double kAgreement_sigmas = 3.5;

/// Sigma of the logarithm: the error of a scale is a factor.
double log_sigma(const ScaleReading& reading) { return reading.sigma / reading.metres_per_mu; }

bool agree(const ScaleReading& a, const ScaleReading& b) {
  const double apart = std::abs(std::log(a.metres_per_mu / b.metres_per_mu));
  return apart <= kAgreement_sigmas * std::hypot(log_sigma(a), log_sigma(b));
}

/// Whether all readings of a set (bit i: reading i) agree with each other.
bool consistent(const ScaleReadings& readings, std::uint32_t set) {
  for (std::size_t i = 0; i < readings.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool both = (set >> i & 1U) != 0 && (set >> j & 1U) != 0;
      if (both && !agree(readings[i], readings[j])) {
        return false;
      }
    }
  }
  return true;
}

FusedScale mean_of(const ScaleReadings& readings, std::uint32_t set) {
  FusedScale fused{.known = true};
  double weights = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if ((set >> i & 1U) != 0) {
      const double weight = 1.0 / (log_sigma(readings[i]) * log_sigma(readings[i]));
      weights += weight;
      sum += weight * std::log(readings[i].metres_per_mu);
      fused.used[i] = true;
    }
  }
  fused.metres_per_mu = std::exp(sum / weights);
  fused.sigma = fused.metres_per_mu / std::sqrt(weights);
  return fused;
}

}  // namespace

bool add_reading(const ScaleReading& reading, ScaleReadings& readings) {
  const bool number = std::isfinite(reading.metres_per_mu) && reading.metres_per_mu > 0.0 &&
                      std::isfinite(reading.sigma) && reading.sigma > 0.0;
  if (!number || reading.source == ScaleSource::kNone) {
    return false;
  }
  for (ScaleReading& earlier : readings) {
    if (earlier.source == reading.source) {
      earlier = reading;
      return true;
    }
  }
  return readings.push_back(reading);
}

FusedScale fuse_scales(const ScaleReadings& readings) {
  std::uint32_t largest = 0;
  for (std::uint32_t set = 1; set < (1U << readings.size()); ++set) {
    if (std::popcount(set) > std::popcount(largest) && consistent(readings, set)) {
      largest = set;
    }
  }
  const auto agreeing = static_cast<std::size_t>(std::popcount(largest));
  FusedScale fused;
  if (2 * agreeing > readings.size()) {
    fused = mean_of(readings, largest);
  }
  fused.contradiction = agreeing < readings.size();
  return fused;
}

}  // namespace polhode
