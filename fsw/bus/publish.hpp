// The results of a step, as packets.
#pragma once

#include "bus/view.hpp"

namespace polhode::bus {

/// Every accepted frame gets exactly one motion packet, valid or not; then the packets that are
/// due: model, prediction, shape, housekeeping, events, a part of a requested cloud.
void publish(const View& view, BusState* bus);

}  // namespace polhode::bus
