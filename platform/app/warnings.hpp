// Warnings about likely mistakes in the inputs, printed before anything starts.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// A line each on standard error.
void print_warnings(std::span<const std::string> warnings);

/// Prints warnings about the section [camera] of a configuration.
/// @throws UnusableInput naming the file where its numbers stand in another order.
void check_configured_camera(const std::filesystem::path& config, const CameraParameters& camera);

}  // namespace polhode::platform
