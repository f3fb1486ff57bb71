// Time stamps of a sequence: are they nanoseconds, and those of the images?
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace polhode::platform {

/// Compares the intervals of the stamps with the rate that the camera's file names.
/// @param stamps_ns  strictly increasing
/// @param table      the file that they are from, for messages
/// @return warnings, one line each: another rate than the file's, images in bursts, gaps.
/// @throws UnusableInput where they cannot be nanoseconds: more images a second than any camera
/// takes, or intervals that are those of `rate_hz` in a unit a thousand, a million or a thousand
/// million times as long.
std::vector<std::string> stamp_warnings(std::span<const std::int64_t> stamps_ns,
                                        std::optional<double> rate_hz,
                                        const std::filesystem::path& table);

/// A camera reads an image before it takes the next one.
/// @param readout_ns  from the first row to the last; negative: from the last one up
/// @return a warning; empty: none.
std::string readout_warning(std::span<const std::int64_t> stamps_ns, double readout_ns);

}  // namespace polhode::platform
