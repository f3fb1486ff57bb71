// Commands carried out between two frames.
#pragma once

#include <cstdint>
#include <span>

#include "pipeline/component.hpp"

namespace polhode {

/// Checks and carries out, in order, at most limits::kStepCommands commands. Those beyond are
/// rejected unread. Each is counted and answered by an event.
void execute_commands(std::span<const std::span<const std::uint8_t>> commands,
                      Component::State* state);

}  // namespace polhode
