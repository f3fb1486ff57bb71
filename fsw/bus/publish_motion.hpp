// Motion model and predictions on the bus.
#pragma once

#include <cstdint>

#include "bus/view.hpp"

namespace polhode::bus {

/// What rates and predictions rest on, as a value of the field `dynamics`.
std::uint8_t dynamics_in_force(const View& view);

/// What is known of the motion at this frame: by the dynamics where they hold, else the local rate
/// and why they are refused.
void send_model(const View& view, BusState* bus);

/// Goes on with the predictions under way and sends the one that has been reached. With `due` new
/// ones begin, if the last are through; where the dynamics are refused one by the last poses is
/// sent.
void send_prediction(const View& view, bool due, BusState* bus);

}  // namespace polhode::bus
