// Places that a run writes to. An unusable one is found before the start, not when the first
// checkpoint is lost.
#pragma once

#include <filesystem>
#include <vector>

#include "os/linux/descriptor.hpp"
#include "parameters/machine_options.hpp"

namespace polhode::platform {

/// Whether something else stands where a folder or a file is to be; makes nothing.
/// @throws UnusableInput naming the configuration, the key and the place.
void check_places(const std::filesystem::path& config, const MachineOptions& machine);

/// Makes the folders of run.folder, run.checkpoint and recording.folder where they are missing,
/// after check_places(), and locks what is written to: both folders and the checkpoint.
/// @return the locks: no other run has these places while it lives.
/// @throws UnusableInput naming the configuration, the key, the place and why it cannot be written;
/// RunFailure where that may pass: the machine is short of something, or another process has it.
[[nodiscard]] std::vector<Descriptor> prepare_places(const std::filesystem::path& config,
                                                     const MachineOptions& machine);

}  // namespace polhode::platform
