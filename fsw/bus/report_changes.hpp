// Events that come from what has changed since the last step.
#pragma once

#include "bus/view.hpp"

namespace polhode::bus {

/// Reports where this step ends differently from the last one.
void report_changes(const View& view, BusState* bus);

}  // namespace polhode::bus
