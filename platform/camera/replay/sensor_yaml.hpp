// The camera of a sequence, from its sensor.yaml.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

struct Sensor {
  CameraParameters camera;
  std::optional<double> rate_hz;      ///< pictures a second, where the file says it
  std::vector<std::string> warnings;  ///< one line each, with the file's path
};

/// @throws UnusableInput naming file, field, value and what is allowed.
Sensor read_sensor_yaml(const std::filesystem::path& file);

}  // namespace polhode::platform
