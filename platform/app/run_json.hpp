// run.json: counters and measurements of a live run.
#pragma once

#include <filesystem>
#include <string>

#include "app/live_run.hpp"

namespace polhode::platform {

struct RunJsonInput {
  LiveParts& parts;
  std::string config_hash;
  std::string beginning;  ///< cold or warm, and why
};

void write_run_json(const std::filesystem::path& file, const RunJsonInput& input);

}  // namespace polhode::platform
