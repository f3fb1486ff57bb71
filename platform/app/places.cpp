#include "app/places.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "os/linux/file_lock.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

/// A key of the configuration, and its value.
struct Place {
  const fs::path& config;
  const char* key;
  fs::path path;
};

[[noreturn]] void refuse(const Place& place, const std::string& why) {
  throw UnusableInput(
      fmt::format("{}: {}: {}: {}", place.config.string(), place.key, place.path.string(), why));
}

/// Passes on exceptions of the call, with the place's key.
template <typename Call>
auto of_place(const Place& place, Call call) {
  return named(fmt::format("{}: {}", place.config.string(), place.key), call);
}

void prepare_folder(const Place& place, const fs::path& folder) {
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) {
    of_place(place, [&] {
      fail_at_start(fmt::format("{}: {} cannot be made", place.path.string(), folder.string()),
                    problem.value());
    });
  }
  if (!fs::is_directory(folder, problem)) {
    refuse(place, fmt::format("{} is no folder", folder.string()));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    const int error = errno;
    of_place(place, [&] {
      fail_at_start(
          fmt::format("{}: {} cannot be written to", place.path.string(), folder.string()), error);
    });
  }
}

bool is_same(int a, int b) {
  struct stat of_a {};
  struct stat of_b {};
  return ::fstat(a, &of_a) == 0 && ::fstat(b, &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
         of_a.st_ino == of_b.st_ino;
}

/// Nothing where it is one of those locked already.
void lock_folder(const Place& place, std::vector<Descriptor>* locks) {
  Descriptor folder(::open(place.path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() < 0) {
    const int error = errno;
    of_place(place, [&] { fail_at_start(place.path.string() + ": cannot be opened", error); });
  }
  const bool locked = std::any_of(locks->begin(), locks->end(), [&](const Descriptor& other) {
    return is_same(folder.get(), other.get());
  });
  if (!locked) {
    of_place(place, [&] { lock_file(folder.get(), place.path.string()); });
    locks->push_back(std::move(folder));
  }
}

/// A run's own has had these fields since the first version; an empty file is no loss. A link is
/// replaced, which leaves its target unchanged.
bool is_of_others(const fs::path& run_json) {
  std::error_code absent;
  if (fs::symlink_status(run_json, absent).type() != fs::file_type::regular) {
    return false;
  }
  constexpr std::size_t kBytesMax = std::size_t{1} << 20U;
  std::ifstream in(run_json, std::ios::binary);
  std::string text(kBytesMax, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
  return !text.empty() && (text.find("\"config_hash\"") == std::string::npos ||
                           text.find("\"frames_accepted\"") == std::string::npos);
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
  if (!machine.run.folder.empty() && is_of_others(fs::path(machine.run.folder) / "run.json")) {
    refuse({config, "run.folder", machine.run.folder},
           "holds a run.json that no run wrote; move it away or name another folder");
  }
  if (fs::is_directory(machine.run.checkpoint, problem)) {
    refuse({config, "run.checkpoint", machine.run.checkpoint},
           "is a folder; allowed is a file's name");
  }
}

std::vector<Descriptor> prepare_places(const fs::path& config, const MachineOptions& machine) {
  check_places(config, machine);
  std::vector<Descriptor> locks;
  for (const Place& place : {Place{config, "run.folder", machine.run.folder},
                             Place{config, "recording.folder", machine.recording.folder}}) {
    if (!place.path.empty()) {
      prepare_folder(place, place.path);
      lock_folder(place, &locks);
    }
  }
  if (!machine.run.checkpoint.empty()) {
    const Place place{config, "run.checkpoint", machine.run.checkpoint};
    prepare_folder(place, fs::absolute(place.path).parent_path());
    locks.push_back(of_place(place, [&] { return lock_beside(place.path); }));
  }
  return locks;
}

}  // namespace polhode::platform
