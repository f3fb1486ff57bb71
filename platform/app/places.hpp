// Where a run writes to. What will not do is found before it starts, not when the first checkpoint
// is lost.
#pragma once

#include <filesystem>

#include "parameters/machine_options.hpp"

namespace polhode::platform {

/// Whether something else stands where a folder or a file is to be; makes nothing.
/// @throws UnusableInput naming the configuration, the key and the place.
void check_places(const std::filesystem::path& config, const MachineOptions& machine);

/// Makes the folders of run.folder, run.checkpoint and recording.folder where they are missing,
/// after check_places().
/// @throws UnusableInput naming the configuration, the key, the place and why it cannot be written.
void prepare_places(const std::filesystem::path& config, const MachineOptions& machine);

}  // namespace polhode::platform
