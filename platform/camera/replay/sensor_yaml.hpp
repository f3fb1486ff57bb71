// The camera of a sequence, from its sensor.yaml.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// Whether `intrinsics: auto`, which is to be estimated on the ground, is refused.
enum class LensNeed { kNumbers, kAny };

struct Sensor {
  CameraParameters camera;
  bool intrinsics_known = true;   ///< else `camera` has a guess: the focal length is the width
  std::optional<double> rate_hz;  ///< images a second, where the file has it
  std::map<std::string, std::string> fields;  ///< all that hold one word or number, as they stand
  std::vector<std::string> warnings;          ///< one line each, with the file's path
};

/// @throws UnusableInput naming file, field, value and what is allowed.
Sensor read_sensor_yaml(const std::filesystem::path& file, LensNeed need = LensNeed::kNumbers);

}  // namespace polhode::platform
