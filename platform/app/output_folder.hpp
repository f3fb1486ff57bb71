// The folder that a replay writes into. Nothing in it is overwritten that a replay did not write.
#pragma once

#include <filesystem>

#include "os/linux/descriptor.hpp"

namespace polhode::platform {

/// Creates the folder if it is absent, and marks it as a replay's. In a folder of an earlier replay
/// the files that a replay writes are removed; others stay.
/// @return its lock: no other replay has the folder while it lives.
/// @throws UnusableInput: it cannot be created or written, or it holds files and no replay wrote
/// it; RunFailure where that may pass: the disk is full, another process has it.
[[nodiscard]] Descriptor prepare_output_folder(const std::filesystem::path& folder);

/// Is that one of the files that a replay writes into its folder?
bool is_own_file(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace polhode::platform
