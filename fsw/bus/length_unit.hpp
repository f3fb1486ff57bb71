// The unit that lengths are published in.
#pragma once

#include <cstdint>

namespace polhode::bus {

/// Scale of a run: metres per map unit, once it is known.
struct LengthUnit {
  bool known = false;
  double metres_per_mu = 1.0;
  double relative_sigma = 0.0;
  std::uint32_t number = 0;  ///< of the scale in force
};

}  // namespace polhode::bus
