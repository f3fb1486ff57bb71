#include "app/beginning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>

#include "app/model_file.hpp"
#include "errors.hpp"
#include "input_text.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

/// Neither is begun from again; the last one stays for people to look at.
void put_aside(const fs::path& checkpoint) {
  std::error_code problem;
  fs::rename(checkpoint, checkpoint.string() + ".suspect", problem);
  fs::remove(checkpoint_before(checkpoint), problem);
}

/// A file that no run left is somebody's: it gets a name that nothing has, and the run goes on.
/// @return that name; empty: it may be replaced.
std::string keep_of_others(const fs::path& file) {
  constexpr std::string_view kMagic = "PLHCHK";  // of all versions
  std::array<char, kMagic.size()> begin{};
  std::error_code problem;
  if (!fs::is_regular_file(file, problem) || fs::file_size(file, problem) == 0) {
    return "";
  }
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  if (std::string_view(begin.data(), begin.size()) == kMagic) {
    return "";
  }
  std::string kept = file.string() + ".found";
  for (int i = 2; fs::exists(fs::symlink_status(kept, problem)); ++i) {
    kept = fmt::format("{}.found{}", file.string(), i);
  }
  fs::rename(file, kept, problem);
  return problem ? "" : kept;
}

}  // namespace

Beginning::Beginning(const MachineOptions& machine,
                     const std::string& config_hash,
                     const std::optional<polhode_key>& key)
    : machine_(machine), key_(key) {
  std::memcpy(identity_.config_hash.data(),
              config_hash.data(),
              std::min(config_hash.size(), identity_.config_hash.size()));
  identity_.build_id = this_build();
  if (machine.device.clock == "monotonic") {
    identity_.boot_id = this_boot();
  }
}

std::string Beginning::take(const fs::path& file, Component& component) {
  loaded_ = load_checkpoint_file(
      file, identity_, moment_now(), machine_.run.checkpoint_age_s_max, key_ ? &*key_ : nullptr);
  if (loaded_.refusal.empty() && crashes_.was_tried(loaded_.checksum)) {
    loaded_.refusal = "a run that began from it crashed";
  }
  if (loaded_.refusal.empty()) {
    watch_->begins_from(loaded_.checksum);
    if (!restore_checkpoint(loaded_.content, &component)) {
      loaded_.refusal = "holds values that no run leaves";
      watch_->begins_from(0);
    }
  }
  std::string refusal = loaded_.refusal;
  if (!refusal.empty()) {
    loaded_ = {};
  }
  return refusal;
}

void Beginning::restore(Component& component) {
  const fs::path& last = machine_.run.checkpoint;
  if (last.empty()) {
    take_model(component);
    return;
  }
  crashes_ = read_crash_mark(crash_mark_file(last));
  watch_.emplace(last, crashes_);
  try {
    restore_last(component);
    if (loaded_.bytes.empty()) {
      take_model(component);
    }
  } catch (...) {
    leave_crash_mark();
    throw;
  }
}

void Beginning::take_model(Component& component) {
  const fs::path& file = machine_.run.model;
  if (file.empty()) {
    return;
  }
  TargetModelFacts facts;
  std::string refusal;
  if (crashes_.crashes >= CrashMark::kWarmMax) {
    refusal = "the runs before crashed";  // presumably by this checkpoint
  } else {
    try {
      refusal = load_model_file(file, &component, &facts);
    } catch (const RunFailure& failure) {
      refusal = failure.what();
    }
  }
  how_ += refusal.empty()
              ? fmt::format("; with the model {}, {} landmarks", file.string(), facts.landmarks)
              : fmt::format("; the model is not used: {}: {}", file.string(), refusal);
  if (refusal.empty()) {
    loaded_ = checkpoint_in_memory(
        component, {.identity = identity_, .boot_id = this_boot(), .stepped = moment_now()});
  }
}

void Beginning::restore_last(Component& component) {
  const fs::path& last = machine_.run.checkpoint;
  if (crashes_.crashes >= CrashMark::kWarmMax) {
    how_ = fmt::format("cold: {} runs in a row crashed soon after their start", crashes_.crashes);
    put_aside(last);
    return;
  }
  how_ = "cold: no checkpoint";
  std::string refused;
  for (const fs::path& file : {last, checkpoint_before(last)}) {
    if (is_absent(file)) {
      continue;
    }
    const std::string refusal = take(file, component);
    if (refusal.empty()) {
      restarts_ = loaded_.restarts + 1;
      how_ = fmt::format("warm: from frame {}, {:.1f} s ago{}",
                         component.counters().frames_in,
                         loaded_.age_s,
                         refused.empty() ? "" : "; the last checkpoint is not used: " + refused);
      return;
    }
    const std::string kept = keep_of_others(file);
    refused = !refused.empty() ? refused
              : kept.empty()   ? refusal
                               : fmt::format("{}; what was there is kept as {}", refusal, kept);
    how_ = fmt::format("cold: the checkpoint is not used: {}", refused);
  }
}

}  // namespace polhode::platform
