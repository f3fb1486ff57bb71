// polhode recording list | export: lists recordings, and writes a recorded run as a sequence.
#pragma once

#include <cstdint>
#include <filesystem>

namespace polhode::platform {

/// A line for each run in the folder.
void list_recordings(const std::filesystem::path& folder);

struct ExportArguments {
  std::filesystem::path folder;
  std::filesystem::path out;
  std::int64_t run_utc_ns = 0;  ///< as listed; 0: the last one
};

/// @throws UnusableInput, RunFailure.
void export_recording(const ExportArguments& arguments);

}  // namespace polhode::platform
