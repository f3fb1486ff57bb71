// Decides which datagrams at a command port are commands of an authorised sender.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "transport/command_window.hpp"
#include "transport/datagram/datagram.hpp"
#include "transport/number_file.hpp"

namespace polhode::platform {

/// As in a configuration, section [commands].
struct CommandSettings {
  std::filesystem::path key;     ///< file; empty: commands are not signed
  std::filesystem::path window;  ///< file of the greatest number taken; with a key only
  bool unauthenticated = false;  ///< without a key, UDP takes commands from anybody
};

/// Counts of the datagrams that arrived.
struct CommandCounts {
  std::uint32_t received = 0;
  std::uint32_t passed = 0;            ///< to the component, which has its own checks
  std::uint32_t refused_sender = 0;    ///< a Unix socket: another user's
  std::uint32_t refused_form = 0;      ///< no packet with a trailer
  std::uint32_t refused_mac = 0;       ///< not by this key
  std::uint32_t refused_number = 0;    ///< taken before, or too old to decide
  std::uint32_t numbers_not_kept = 0;  ///< passed, but the disk refused the number, or was slow
};

class CommandGuard {
 public:
  /// Without a key all datagrams pass, but for those of other users on a Unix socket.
  CommandGuard() = default;
  /// @throws UnusableInput: the key cannot be used, or the file of numbers; RunFailure: the disk's
  /// fault.
  CommandGuard(const CommandSettings& settings, std::uint64_t utc_ns);

  /// Counts the datagram, and takes the trailer off. What passes is handed on after keep_numbers().
  /// @param datagram  changed in place.
  /// @return the command packet as it was before it was signed; nothing when refused.
  std::optional<std::span<const std::uint8_t>> pass(std::span<std::uint8_t> datagram,
                                                    const Received& received);

  /// Once a step, for all that passed since the last call, so that none of them passes after a
  /// restart. May wait, for NumberFile::kWait at most. What the file has not by the next call is
  /// counted.
  void keep_numbers();

  [[nodiscard]] bool has_key() const { return key_.has_value(); }
  [[nodiscard]] const CommandCounts& counts() const { return counts_; }
  [[nodiscard]] std::uint64_t highest() const { return window_.highest(); }
  /// For people, at start: where numbers begin, if not where they ended.
  [[nodiscard]] std::string remark() const { return numbers_ ? numbers_->remark() : ""; }

 private:
  std::optional<std::span<const std::uint8_t>> take_trailer(std::span<std::uint8_t> datagram);

  std::optional<polhode_key> key_;
  std::unique_ptr<NumberFile> numbers_;
  struct Unkept {
    std::uint32_t commands = 0;
    std::uint64_t number = 0;  ///< the greatest of them
  };
  Unkept passed_;  ///< since the last keep_numbers()
  Unkept late_;    ///< handed to the file then, which was slow
  CommandWindow window_;
  CommandCounts counts_;
};

/// @throws UnusableInput with a description of key files.
polhode_key read_key(const std::filesystem::path& file);

/// Of the settings, if they name one. @throws UnusableInput naming commands.key.
std::optional<polhode_key> key_of(const CommandSettings& settings);

/// @return empty, or the mistake in these settings, by key: ports of an unknown kind, or ports that
/// would take commands from anybody without explicit permission.
std::string problem_of(const std::vector<std::string>& receive, const CommandSettings& settings);

}  // namespace polhode::platform
