// A checkpoint on disk: whole or refused.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "os/linux/build_id.hpp"
#include "os/linux/clock.hpp"
#include "os/linux/memory/table_memory.hpp"
#include "pipeline/component.hpp"
#include "signing/polhode_sign.h"

namespace polhode::platform {

/// Identity of a checkpoint's run. A checkpoint with another one is not used.
struct CheckpointIdentity {
  std::array<char, 64> config_hash{};  ///< hexadecimal digits, of the parameters
  std::array<char, 36> boot_id{};      ///< zeros where time stamps do not depend on the boot
  BuildId build_id{};                  ///< of the program: tables lie otherwise in another one
};

/// Facts written with a state.
struct CheckpointStamp {
  CheckpointIdentity identity;
  std::array<char, 36> boot_id{};  ///< of this_boot()
  Moment stepped;                  ///< its last frame: from then on it ages
  std::uint32_t restarts =
      0;  ///< of the program, from checkpoint to checkpoint, since a cold start
};

/// Of this machine since it was started; zeros where it is not available.
std::array<char, 36> this_boot();

/// The one before the last, beside it.
std::filesystem::path checkpoint_before(const std::filesystem::path& file);

/// Where the files of a checkpoint lie.
struct CheckpointPlaces {
  explicit CheckpointPlaces(const std::filesystem::path& file);
  std::filesystem::path file;
  std::filesystem::path before;  ///< the one before
  std::filesystem::path beside;  ///< one that is being written
};

/// Writes beside the file and has it on the disk. Then the old one becomes the one before, and the
/// new one takes its place: at no moment is there none, or half of one.
/// @param key  signs it; nullptr: it is not signed, and nothing takes memory.
/// @return false when the disk did not take it; the old one is still there.
bool write_checkpoint_file(const CheckpointPlaces& places,
                           const CheckpointStamp& stamp,
                           std::span<const std::uint8_t> content,
                           const polhode_key* key = nullptr);

struct LoadedCheckpoint {
  std::unique_ptr<TableMemory> memory;    ///< of the content: goes with it, beside the pools
  std::span<const std::uint8_t> bytes;    ///< the file; empty when refused
  std::span<const std::uint8_t> content;  ///< of it the state; empty when refused
  std::uint32_t checksum = 0;             ///< identifies it
  std::string refusal;                    ///< why; empty when it is good
  std::string stranger;                   ///< why it is not this user's own; empty when it is
  double age_s = 0.0;
  std::uint32_t restarts = 0;
};

/// A component's state as a file would have it, in memory.
LoadedCheckpoint checkpoint_in_memory(const Component& component, const CheckpointStamp& stamp);

/// Loads for a replay: whole and of this build, of any configuration, boot and age.
LoadedCheckpoint load_whole_checkpoint(const std::filesystem::path& file, const BuildId& build);

/// Loads for a live run: of this configuration and boot, not too old, and a file of this user's
/// own that nobody else may write to. Its age is by the clock that nobody sets, unless the machine
/// was started since.
/// @param key  nullptr: signed or not is the same.
LoadedCheckpoint load_checkpoint_file(const std::filesystem::path& file,
                                      const CheckpointIdentity& identity,
                                      const Moment& now,
                                      double age_s_max,
                                      const polhode_key* key = nullptr);

}  // namespace polhode::platform
