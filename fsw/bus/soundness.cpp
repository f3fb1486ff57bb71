#include "bus/soundness.hpp"

#include <algorithm>

#include "base/sound.hpp"
#include "bus/dynamics_telemetry.hpp"

namespace polhode {
namespace {
using sound::is_at_least;
using sound::is_bool;
using sound::is_bounded;
using sound::is_enum;
}  // namespace

bool is_sound(const ScaleNumber& scale) {
  return is_bool(scale.unit.known) && is_at_least(scale.unit.metres_per_mu, 0.0);
}

bool is_sound(const ServicerAttitude& servicer) {
  // Commands carry a quaternion to single precision.
  constexpr double kNormError = 1e-3;
  return is_bool(servicer.known) && is_bounded(servicer.w_C_rad_s) &&
         is_bounded(servicer.q_IC.coeffs()) && std::abs(servicer.q_IC.norm() - 1.0) < kNormError;
}

bool is_sound(const Reported& reported) {
  return is_bool(reported.started) && is_bool(reported.stamps_doubted) &&
         is_bool(reported.rate_implausible) && is_enum(reported.mode, kLastMode) &&
         reported.dynamics <= bus::kDynamicsOrbit && is_sound(reported.scale);
}

bool is_sound(const BusState& bus) {
  const auto& q = bus.q_CT_last;
  return std::all_of(bus.stream.sequence.begin(),
                     bus.stream.sequence.end(),
                     [](std::uint16_t count) { return count < bus::kSequenceModulus; }) &&
         is_enum(bus.commands.last_rejection, bus::Rejection::kTooMany) && is_sound(bus.servicer) &&
         is_sound(bus.reported) && is_sound(bus.scale) &&
         std::all_of(q.begin(), q.end(), [](double value) { return is_bounded(value); });
}

}  // namespace polhode
