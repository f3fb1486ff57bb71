// The camera of a sequence, from its sensor.yaml.
#pragma once

#include <filesystem>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// @throws UnusableInput naming file, field, value and what is allowed.
CameraParameters read_sensor_yaml(const std::filesystem::path& file);

}  // namespace polhode::platform
