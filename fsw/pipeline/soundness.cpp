#include "pipeline/soundness.hpp"

#include "base/sound.hpp"
#include "bus/soundness.hpp"
#include "map/soundness.hpp"
#include "motion/soundness.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/state.hpp"
#include "shape/soundness.hpp"

namespace polhode {
namespace {

bool is_sound(const Configuration& configuration) {
  return configuration.table_crc == table_crc(configuration.parameters) &&
         !check(configuration.parameters);
}

}  // namespace

bool is_sound(const Component::State& s) {
  const std::int64_t now_ns = s.clock.timestamp_ns;
  return is_sound(s.configuration) && sound::is_bool(s.mode.held) &&
         sound::is_bool(s.clock.time_known) &&
         is_sound(s.mapping.map, to_model(s.configuration.parameters.camera), now_ns) &&
         is_sound(s.mapping.drift) && is_sound(s.motion, now_ns) && is_sound(s.shape) &&
         is_sound(s.scale) && is_sound(s.camera) && is_sound(s.features.resting) && is_sound(s.bus);
}

}  // namespace polhode
