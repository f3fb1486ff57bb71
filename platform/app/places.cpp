#include "app/places.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "errors.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

/// A key of the configuration, and what it says.
struct Place {
  const fs::path& config;
  const char* key;
  fs::path path;
};

[[noreturn]] void refuse(const Place& place, const std::string& why) {
  throw UnusableInput(
      fmt::format("{}: {}: {}: {}", place.config.string(), place.key, place.path.string(), why));
}

void prepare_folder(const Place& place, const fs::path& folder) {
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) {
    refuse(place, fmt::format("{} cannot be made: {}", folder.string(), problem.message()));
  }
  if (!fs::is_directory(folder, problem)) {
    refuse(place, fmt::format("{} is no folder", folder.string()));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse(place,
           fmt::format("{} cannot be written to: {}",
                       folder.string(),
                       std::generic_category().message(errno)));
  }
}

}  // namespace

void check_places(const fs::path& config, const MachineOptions& machine) {
  for (const Place& place : {Place{config, "run.folder", machine.run.folder},
                             Place{config, "recording.folder", machine.recording.folder}}) {
    std::error_code absent;
    if (fs::exists(place.path, absent) && !fs::is_directory(place.path, absent)) {
      refuse(place, "is no folder");
    }
  }
  std::error_code problem;
  if (fs::is_directory(machine.run.checkpoint, problem)) {
    refuse({config, "run.checkpoint", machine.run.checkpoint},
           "is a folder; allowed is a file's name");
  }
}

void prepare_places(const fs::path& config, const MachineOptions& machine) {
  check_places(config, machine);
  if (!machine.run.folder.empty()) {
    prepare_folder({config, "run.folder", machine.run.folder}, machine.run.folder);
  }
  if (!machine.recording.folder.empty()) {
    prepare_folder({config, "recording.folder", machine.recording.folder},
                   machine.recording.folder);
  }
  if (!machine.run.checkpoint.empty()) {
    const Place place{config, "run.checkpoint", machine.run.checkpoint};
    prepare_folder(place, fs::absolute(place.path).parent_path());
  }
}

}  // namespace polhode::platform
