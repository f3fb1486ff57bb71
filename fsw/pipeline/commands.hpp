// Commands carried out between two frames.
#pragma once

#include <cstdint>
#include <span>

#include "pipeline/component.hpp"

namespace polhode {

/// Checks and carries out, in order, at most limits::kStepCommands commands; those beyond are
/// rejected. Each is counted and answered by an event. The first limits::kStepCommands are read,
/// the others not even looked at.
void execute_commands(std::span<const std::span<const std::uint8_t>> commands,
                      Component::State* state);

}  // namespace polhode
