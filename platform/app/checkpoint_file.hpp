// A checkpoint on disk: whole or refused.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "os/linux/memory/table_memory.hpp"

namespace polhode::platform {

/// What a checkpoint belongs to. Another one's is not used.
struct CheckpointIdentity {
  std::array<char, 64> config_hash{};  ///< hexadecimal digits, of the parameters
  std::array<char, 36> boot_id{};      ///< zeros where time stamps do not depend on the boot
};

/// What is written with a state.
struct CheckpointStamp {
  CheckpointIdentity identity;
  std::int64_t utc_ns = 0;
  std::uint32_t restarts =
      0;  ///< of the program, from checkpoint to checkpoint, since a cold start
};

/// Of this machine since it was started; zeros when it does not tell.
std::array<char, 36> this_boot();

/// Writes beside the file, has it on the disk, then takes the old one's place: at no moment is
/// there none, or half of one. Takes no memory.
/// @return false when the disk did not take it; the old one is still there.
bool write_checkpoint_file(const std::filesystem::path& file,
                           const std::filesystem::path& beside,
                           const CheckpointStamp& stamp,
                           std::span<const std::uint8_t> content);

struct LoadedCheckpoint {
  std::unique_ptr<TableMemory> memory;    ///< of the content: goes with it, beside the pools
  std::span<const std::uint8_t> content;  ///< empty when refused
  std::string refusal;                    ///< why; empty when it is good
  double age_s = 0.0;
  std::uint32_t restarts = 0;
};

LoadedCheckpoint load_checkpoint_file(const std::filesystem::path& file,
                                      const CheckpointIdentity& identity,
                                      std::int64_t utc_ns,
                                      double age_s_max);

}  // namespace polhode::platform
