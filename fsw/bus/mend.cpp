#include "bus/mend.hpp"

#include "base/validity.hpp"
#include "bus/soundness.hpp"

namespace polhode {
namespace {

bool is_valid(const CloudRequest& cloud) {
  return cloud.points_T.size() <= cloud.points_T.capacity() && cloud.next <= cloud.points_T.size();
}

}  // namespace

Repair repair(BusState* bus) {
  Repair repaired;
  const auto put_right = [&](auto* value, const auto& with) {
    *value = with;
    ++repaired.entries;
  };
  if (!is_valid(bus->cloud)) {
    bus->cloud.points_T.clear();
    put_right(&bus->cloud.next, std::size_t{0});
  }
  LookAhead& walk = bus->predictions.walk;
  if (!validity::is_bool(walk.under_way) ||
      (walk.under_way && walk.next >= kPredictionsAhead_s.size())) {
    put_right(&walk.under_way, false);
  }
  if (is_valid(*bus)) {
    return repaired;
  }
  if (!is_valid(bus->servicer)) {
    put_right(&bus->servicer, ServicerAttitude{});
  }
  if (!is_valid(bus->reported)) {
    const Counters counters = bus->reported.counters;
    put_right(&bus->reported, Reported{.started = true, .counters = counters});
  }
  if (!is_valid(bus->scale)) {
    put_right(&bus->scale, ScaleNumber{.number = bus->scale.number});
  }
  if (!is_valid(*bus)) {
    for (std::uint16_t& count : bus->stream.sequence) {
      count %= bus::kSequenceModulus;
    }
    bus->commands.last_rejection = bus::Rejection::kNone;
    put_right(&bus->q_CT_last, BusState{}.q_CT_last);
  }
  return repaired;
}

}  // namespace polhode
