// A component restored from a checkpoint, for work on the ground.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/component.hpp"

namespace polhode::platform {

/// Into a component that has just been created. Parameters that differ from the configured ones are
/// reported.
/// @param named  what a person called the file, for messages.
/// @throws UnusableInput: not whole, of another build or camera, or with values that no run leaves.
void start_from_checkpoint(const std::filesystem::path& file,
                           const std::string& named,
                           const Parameters& configured,
                           Component& component);

}  // namespace polhode::platform
