// Events by changes since the last step.
#pragma once

#include <cstdint>

#include "bus/events.hpp"
#include "bus/view.hpp"

namespace polhode::bus {

/// Reports where this step ends differently from the last one.
void report_changes(const View& view, BusState* bus);

/// Reports a frame that was not used, unless it was held by command, or used with care.
void report_frame(std::uint32_t frame, FrameUse use, const FrameVerdict& verdict, EventLog* log);

}  // namespace polhode::bus
