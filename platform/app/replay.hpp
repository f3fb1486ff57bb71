// polhode replay: a sequence from disk through the component, everything that it publishes into a
// folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "camera/replay/sequence.hpp"

namespace polhode::platform {

struct ReplayArguments {
  std::filesystem::path config;
  std::filesystem::path sequence;
  std::filesystem::path out;
  std::filesystem::path checkpoint;  ///< content of one; empty: cold
  std::filesystem::path model;       ///< of the target, from another pass; empty: none
  std::filesystem::path save_model;  ///< where the map's is left; empty: nowhere
  PixelChoices pixels;
  bool realtime = false;
  bool one_core = false;             ///< jobs run between the steps, on the same thread
  std::uint32_t job_latency_ms = 0;  ///< for tests: jobs are held back by a random time up to this
  std::filesystem::path commands;    ///< over [commands] file of the configuration; empty: that
  bool memory_trap = false;  ///< for tests: exit code 5 when memory is asked for between the first
                             ///< frame and the last; the files of the end are then not written
  bool masks = false;        ///< write the target's masks
  std::vector<std::string> settings;
};

/// @throws UnusableInput before anything started; RunFailure afterwards.
void replay(const ReplayArguments& arguments);

}  // namespace polhode::platform
