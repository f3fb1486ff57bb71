// Configuration: a TOML file and single settings from the command line, checked as a whole.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

struct Configuration {
  Parameters parameters;
  std::vector<std::string>
      origins;              ///< per row of parameter_table(): "" (default), "FILE:LINE" or "--set"
  bool has_camera = false;  ///< all of [camera] that has no sensible default is given
};

/// @param settings each `key=value`: dotted key, TOML value; a later one wins over an earlier one
/// and over the file.
/// @throws UnusableInput naming file and line (or --set), key, value and allowed range: no regular
/// file, not TOML, unknown key (with the nearest known one), wrong type, out of range, values that
/// do not go together.
Configuration load_configuration(const std::filesystem::path& file,
                                 std::span<const std::string> settings);

/// The effective table in its one canonical text form, `key = value` a line; keys that nobody gave
/// are left out.
std::string canonical_text(const Parameters& parameters);

}  // namespace polhode::platform
