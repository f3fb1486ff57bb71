#include "app/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <string>
#include <system_error>

#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "os/linux/file_lock.hpp"
#include "output_file.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = ".polhode-replay";

constexpr const char* kOwnFiles[] = {
    "motion.csv",
    "motion_smoothed.csv",
    "trajectory.tum",
    "causal.tum",
    "smoothed.tum",
    "cloud_raw.ply",
    "cloud.ply",
    "surface.ply",
    "shape.json",
    "motion_model.json",
    "bus.ccsds",
    "observations.csv",
    "masks.pgms",
    "mask_tracks.csv",
    "summary.json",
    ".observations.spool",
};

[[noreturn]] void fail(const fs::path& folder, const std::string& what) {
  throw UnusableInput(fmt::format("--out {}: {}", folder.string(), what));
}

}  // namespace

Descriptor prepare_output_folder(const fs::path& folder) {
  const std::string place = "--out " + folder.string();
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    fail(folder, "exists and is not a folder");
  }
  fs::create_directories(folder, error);
  if (error) {
    fail_at_start(place + ": cannot be created", error.value());
  }
  Descriptor lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.get() < 0) {
    fail_at_start(place + ": cannot be read", errno);
  }
  lock_file(lock.get(), place);
  const bool empty = fs::is_empty(folder, error);
  if (error) {
    fail_at_start(place + ": cannot be read", error.value());
  }
  if (!empty && !fs::exists(folder / kMarker, error)) {
    fail(folder,
         "holds files that no replay wrote; allowed is a new, an empty or an earlier run's folder");
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    fail_at_start(place + ": cannot be written to", errno);
  }
  if (empty) {
    named("--out", [&] {
      write_file(folder / kMarker,
                 "A polhode replay writes here and may overwrite its own files.\n");
    });
  }
  for (const char* name : kOwnFiles) {
    fs::remove(folder / name, error);
    if (error) {
      fail(folder,
           fmt::format("{} of an earlier run cannot be removed: {}", name, error.message()));
    }
  }
  return lock;
}

bool is_own_file(const fs::path& file, const fs::path& folder) {
  std::error_code problem;
  const fs::path of = fs::weakly_canonical(file, problem).parent_path();
  return of == fs::weakly_canonical(folder, problem) &&
         std::find(std::begin(kOwnFiles), std::end(kOwnFiles), file.filename()) !=
             std::end(kOwnFiles);
}

}  // namespace polhode::platform
