// A whole file in memory, in a buffer that is used again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace polhode::platform {

/// The default: an 8192x8192 image of 16-bit colour, stored raw.
inline constexpr std::size_t kFileBytesMax = std::size_t{1} << 30U;

/// @param bytes      keeps its capacity from file to file
/// @param bytes_max  a larger file is not read
/// @return why the file cannot be read, or nothing.
std::optional<std::string> read_file(const std::filesystem::path& file,
                                     std::vector<std::uint8_t>& bytes,
                                     std::size_t bytes_max = kFileBytesMax);

/// The same at a start, where a missing file is fatal.
/// @param what  names the file in exceptions.
/// @throws UnusableInput, or RunFailure for a fault that may pass, as fail_at_start() has it.
void read_file_at_start(const std::filesystem::path& file,
                        const std::string& what,
                        std::vector<std::uint8_t>& bytes,
                        std::size_t bytes_max = kFileBytesMax);

}  // namespace polhode::platform
