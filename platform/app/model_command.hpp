// polhode model save | check: a run's model of its target, for another pass.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace polhode::platform {

struct ModelSaveArguments {
  std::filesystem::path config;      ///< of the run that left the checkpoint, with its camera
  std::filesystem::path checkpoint;  ///< as in run.checkpoint
  std::filesystem::path out;
  std::vector<std::string> settings;
};

/// @throws UnusableInput, RunFailure.
void save_model(const ModelSaveArguments& arguments);

/// A few lines on a model's content.
/// @throws UnusableInput where it is not whole.
std::string describe_model(const std::filesystem::path& file);

/// Prints them.
void check_model(const std::filesystem::path& file);

}  // namespace polhode::platform
