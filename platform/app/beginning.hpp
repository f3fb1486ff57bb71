// Initial state of a live run: empty, a model of the target, or a checkpoint.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "app/checkpoint_file.hpp"
#include "app/crash_mark.hpp"
#include "parameters/machine_options.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// Bad checkpoints are no reason not to run: the one before the last is tried, then the run begins
/// cold. A crash while one is read or restored leaves a mark, as one soon after does: the watch
/// begins here.
class Beginning {
 public:
  /// @param config_hash  64 hexadecimal digits
  /// @param key  that checkpoints are signed by; empty: they need no signature
  Beginning(const MachineOptions& machine,
            const std::string& config_hash,
            const std::optional<polhode_key>& key = {});

  /// Loads the initial state into a component that has just been created. An exception counts as a
  /// crash for the next start.
  void restore(Component& component);

  [[nodiscard]] const CheckpointIdentity& identity() const { return identity_; }
  [[nodiscard]] const std::optional<polhode_key>& key() const { return key_; }
  /// Cold or warm, and why.
  [[nodiscard]] const std::string& how() const { return how_; }
  /// Of the program, this start included, since a cold one.
  [[nodiscard]] std::uint32_t restarts() const { return restarts_; }
  /// The file that the run begins from, or the state that a model gives; empty when it begins with
  /// neither.
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return loaded_.bytes; }
  /// Its memory goes back; how it was stays known.
  void release_bytes() { loaded_ = {}; }
  /// From restore() on; nullptr: there are no checkpoints.
  [[nodiscard]] CrashWatch* watch() { return watch_ ? &*watch_ : nullptr; }

 private:
  /// From the last checkpoint that will do.
  void restore_last(Component& component);
  /// A model that will not do is no reason not to run either.
  void take_model(Component& component);
  /// @return why this file is not used; empty when the component has it.
  std::string take(const std::filesystem::path& file, Component& component);

  const MachineOptions& machine_;
  std::optional<polhode_key> key_;
  CheckpointIdentity identity_;
  LoadedCheckpoint loaded_;
  CrashMark crashes_;
  std::optional<CrashWatch> watch_;
  std::uint32_t restarts_ = 0;
  std::string how_ = "cold";
};

}  // namespace polhode::platform
