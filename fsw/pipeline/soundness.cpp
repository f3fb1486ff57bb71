#include "pipeline/soundness.hpp"

#include "base/validity.hpp"
#include "bus/soundness.hpp"
#include "map/validity.hpp"
#include "motion/soundness.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/state.hpp"
#include "shape/validity.hpp"

namespace polhode {
namespace {

bool is_valid(const Configuration& configuration) {
  return configuration.table_crc == table_crc(configuration.parameters) &&
         !check(configuration.parameters);
}

}  // namespace

bool is_valid(const Component::State& s) {
  const std::int64_t now_ns = s.clock.timestamp_ns;
  return is_valid(s.configuration) && validity::is_bool(s.mode.held) &&
         validity::is_bool(s.clock.time_known) &&
         is_valid(s.mapping.map, to_model(s.configuration.parameters.camera), now_ns) &&
         is_valid(s.mapping.drift) && is_valid(s.motion, now_ns) && is_valid(s.shape) &&
         is_valid(s.scale) && is_valid(s.camera) && is_valid(s.features.resting) && is_valid(s.bus);
}

}  // namespace polhode
