// Where a live run begins: anew, or where a checkpoint says.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "app/checkpoint_file.hpp"
#include "app/crash_mark.hpp"
#include "parameters/machine_options.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// Bad checkpoints are no reason not to run: the one before the last is tried, then the run begins
/// cold.
class Beginning {
 public:
  /// @param config_hash  64 hexadecimal digits
  Beginning(const MachineOptions& machine, const std::string& config_hash);

  /// Into a component that has just been created.
  void restore(Component& component);

  [[nodiscard]] const CheckpointIdentity& identity() const { return identity_; }
  /// Cold or warm, and why.
  [[nodiscard]] const std::string& how() const { return how_; }
  /// Of the program, this start included, since a cold one.
  [[nodiscard]] std::uint32_t restarts() const { return restarts_; }
  /// The file that the run begins from; empty when it begins cold.
  [[nodiscard]] std::span<const std::uint8_t> octets() const { return loaded_.octets; }
  /// Its memory goes back; how it was stays known.
  void forget_octets() { loaded_ = {}; }
  /// Crashes of the runs before.
  [[nodiscard]] const CrashMark& crashes() const { return crashes_; }
  /// Of the file that the run begins from; 0: cold.
  [[nodiscard]] std::uint32_t checksum() const { return checksum_; }

 private:
  /// @return why this file is not used; empty when the component has it.
  std::string take(const std::filesystem::path& file, Component& component);

  const MachineOptions& machine_;
  CheckpointIdentity identity_;
  LoadedCheckpoint loaded_;
  CrashMark crashes_;
  std::uint32_t checksum_ = 0;
  std::uint32_t restarts_ = 0;
  std::string how_ = "cold";
};

}  // namespace polhode::platform
