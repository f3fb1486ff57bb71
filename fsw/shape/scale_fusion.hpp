// One scale from several readings. Readings that contradict each other are reported, not averaged.
#pragma once

#include <array>
#include <cstddef>

#include "base/fixed_vector.hpp"
#include "shape/options.hpp"

namespace polhode {

struct ScaleReading {
  ScaleSource source = ScaleSource::kNone;
  double metres_per_mu = 0.0;
  double sigma = 0.0;  ///< 1-sigma of metres_per_mu
};

/// At most one reading a source.
using ScaleReadings = FixedVector<ScaleReading, kScaleSources>;

struct FusedScale {
  bool known = false;
  double metres_per_mu = 0.0;  ///< meaningful with `known`
  double sigma = 0.0;
  bool contradiction = false;              ///< readings do not agree within their sigmas
  std::array<bool, kScaleSources> used{};  ///< readings that the scale comes from, by their place
};

/// Adds a reading, or replaces an earlier one of its source. Refuses one that is not finite and
/// positive. @return whether it was taken.
bool add_reading(const ScaleReading& reading, ScaleReadings& readings);

/// Mean of the logarithms weighted by 1 / sigma^2, over the largest set of readings that agree with
/// each other. Where that set is not more than half of the readings, the scale is unknown.
FusedScale fuse_scales(const ScaleReadings& readings);

}  // namespace polhode
