// The sections of a configuration that say where packets go and commands come from, and which
// network is asked. They belong to the machine, not to the estimator's parameters.
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
  std::filesystem::path network_file;   ///< [network] file: ONNX, for outlines; empty: none
};

/// True for `transport`, `commands` and `network`.
bool is_transport_section(std::string_view section);

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
