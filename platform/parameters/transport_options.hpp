// Options of a configuration on the destinations of packets and sources of commands, and on the
// servicer's own. It belongs to the machine, not to the estimator's parameters.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "transport/transports.hpp"

namespace polhode::platform {

struct TransportOptions {
  TransportSettings transport;          ///< [transport] send, receive; [commands] key, window,
                                        ///< unauthenticated
  std::filesystem::path commands_file;  ///< [commands] file: of a replay; empty: none
  std::filesystem::path
      own_structure_file;  ///< [mask] file: image of the servicer's own; empty: none
};

/// True for `transport` and `commands`.
bool is_transport_section(std::string_view section);

/// True for a dotted key that is read here though its section is the estimator's: `mask.file`.
bool is_transport_key(std::string_view key);

/// Reads these sections of the file, then of the settings (key=value as on the command line). For a
/// replay, which takes no commands from anybody: a flight's configuration will do without its key.
/// @throws UnusableInput naming file, key, value and what is allowed.
TransportOptions load_transport_options(const std::filesystem::path& file,
                                        std::span<const std::string> settings);

/// For a live run: who may give commands is settled, too.
TransportOptions load_live_transport_options(const std::filesystem::path& file,
                                             std::span<const std::string> settings);

/// One line a key: key, value.
std::string transport_table(const TransportOptions& options);

}  // namespace polhode::platform
