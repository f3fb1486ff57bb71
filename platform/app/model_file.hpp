// A target's model on disk, for another pass: whole or refused. The same bytes on every machine.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/target_model.hpp"

namespace polhode::platform {

/// Into a component that has just been created.
/// @return why it is not taken, and the component is as it was created; empty when it is.
std::string load_model_file(const std::filesystem::path& file,
                            Component* component,
                            TargetModelFacts* facts);

/// Checks that the place of a new model is free, or has a model.
/// @throws UnusableInput naming the place.
void check_model_place(const std::filesystem::path& file);

/// Writes the component's map as a model, in place of an earlier model.
/// @throws RunFailure where there is no map, or the disk does not take it.
void write_model_file(const std::filesystem::path& file, const Component& component);

/// A few lines for people.
std::string describe(const TargetModelFacts& facts);

}  // namespace polhode::platform
