// Motion model and predictions on the bus.
#pragma once

#include <cstdint>

#include "bus/view.hpp"

namespace polhode::bus {

/// The model behind rates and predictions, as a value of the field `dynamics`.
std::uint8_t dynamics_in_force(const View& view);

/// Sends the motion at this frame: by the dynamics where they are valid, else the local rate and
/// the reason of their refusal.
void send_model(const View& view, BusState* bus);

/// Continues the predictions under way and sends the one that has been reached. With `due` new ones
/// begin, if the last have ended; if the dynamics are refused, one by the last poses is sent.
void send_prediction(const View& view, bool due, BusState* bus);

}  // namespace polhode::bus
