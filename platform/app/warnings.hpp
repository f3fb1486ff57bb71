// What is likely to be wrong, said before anything starts.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// A line each on standard error.
void print_warnings(std::span<const std::string> warnings);

/// The section [camera] of a configuration: what is doubtful is told.
/// @throws UnusableInput naming the file where its numbers stand in another order.
void check_configured_camera(const std::filesystem::path& config, const CameraParameters& camera);

}  // namespace polhode::platform
