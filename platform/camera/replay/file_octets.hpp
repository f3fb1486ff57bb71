// A whole file in memory, in a buffer that is used again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace polhode::platform {

/// @param octets keeps its capacity from file to file.
/// @return why the file cannot be read, or nothing.
std::optional<std::string> read_file(const std::filesystem::path& file,
                                     std::vector<std::uint8_t>& octets);

}  // namespace polhode::platform
