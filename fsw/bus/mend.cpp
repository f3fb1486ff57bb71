#include "bus/mend.hpp"

#include "base/sound.hpp"
#include "bus/soundness.hpp"

namespace polhode {
namespace {

bool is_sound(const CloudRequest& cloud) {
  return cloud.points_T.size() <= cloud.points_T.capacity() && cloud.next <= cloud.points_T.size();
}

}  // namespace

Mended mend(BusState* bus) {
  Mended mended;
  const auto put_right = [&](auto* value, const auto& with) {
    *value = with;
    ++mended.entries;
  };
  if (!is_sound(bus->cloud)) {
    bus->cloud.points_T.clear();
    put_right(&bus->cloud.next, std::size_t{0});
  }
  LookAhead& walk = bus->predictions.walk;
  if (!sound::is_bool(walk.under_way) ||
      (walk.under_way && walk.next >= kPredictionsAhead_s.size())) {
    put_right(&walk.under_way, false);
  }
  if (is_sound(*bus)) {
    return mended;
  }
  if (!is_sound(bus->servicer)) {
    put_right(&bus->servicer, ServicerAttitude{});
  }
  if (!is_sound(bus->reported)) {
    const Counters counters = bus->reported.counters;
    put_right(&bus->reported, Reported{.started = true, .counters = counters});
  }
  if (!is_sound(bus->scale)) {
    put_right(&bus->scale, ScaleNumber{.number = bus->scale.number});
  }
  if (!is_sound(*bus)) {
    for (std::uint16_t& count : bus->stream.sequence) {
      count %= bus::kSequenceModulus;
    }
    bus->commands.last_rejection = bus::Rejection::kNone;
    put_right(&bus->q_CT_last, BusState{}.q_CT_last);
  }
  return mended;
}

}  // namespace polhode
