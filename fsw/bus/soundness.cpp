#include "bus/soundness.hpp"

#include <algorithm>

#include "base/validity.hpp"
#include "bus/dynamics_telemetry.hpp"

namespace polhode {
namespace {
using validity::is_at_least;
using validity::is_bool;
using validity::is_bounded;
using validity::is_enum;
}  // namespace

bool is_valid(const ScaleNumber& scale) {
  return is_bool(scale.unit.known) && is_at_least(scale.unit.metres_per_mu, 0.0);
}

bool is_valid(const ServicerAttitude& servicer) {
  // Commands carry a quaternion to single precision.
  constexpr double kNormError = 1e-3;
  return is_bool(servicer.known) && is_bounded(servicer.w_C_rad_s) &&
         is_bounded(servicer.q_IC.coeffs()) && std::abs(servicer.q_IC.norm() - 1.0) < kNormError;
}

bool is_valid(const Reported& reported) {
  return is_bool(reported.started) && is_bool(reported.stamps_doubted) &&
         is_bool(reported.rate_implausible) && is_enum(reported.mode, kLastMode) &&
         reported.dynamics <= bus::kDynamicsOrbit && is_valid(reported.scale);
}

bool is_valid(const BusState& bus) {
  const auto& q = bus.q_CT_last;
  return std::all_of(bus.stream.sequence.begin(),
                     bus.stream.sequence.end(),
                     [](std::uint16_t count) { return count < bus::kSequenceModulus; }) &&
         is_enum(bus.commands.last_rejection, bus::Rejection::kTooMany) && is_valid(bus.servicer) &&
         is_valid(bus.reported) && is_valid(bus.scale) &&
         std::all_of(q.begin(), q.end(), [](double value) { return is_bounded(value); });
}

}  // namespace polhode
