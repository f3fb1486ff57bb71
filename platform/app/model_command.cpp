#include "app/model_command.hpp"

#include <fmt/format.h>

#include "app/checkpoint_start.hpp"
#include "app/component_memory.hpp"
#include "app/model_file.hpp"
#include "errors.hpp"
#include "parameters/load.hpp"

namespace polhode::platform {
namespace {

Component& make_component(const ComponentMemory& memory,
                          const Parameters& parameters,
                          const std::string& where) {
  Result<Component*> made = Component::create(memory.span(), parameters);
  if (!made) {
    throw UnusableInput(fmt::format("{}: {}", where, made.error().message));
  }
  return *made.value();
}

/// A model has no camera of its own: any will do.
Parameters with_some_camera() {
  Parameters parameters;
  parameters.camera = {.width_px = 640,
                       .height_px = 480,
                       .fu_px = 600.0,
                       .fv_px = 600.0,
                       .cu_px = 319.5,
                       .cv_px = 239.5};
  return parameters;
}

}  // namespace

void save_model(const ModelSaveArguments& arguments) {
  const Configuration configuration = load_configuration(arguments.config, arguments.settings);
  const std::string where = arguments.config.string();
  if (!configuration.has_camera) {
    throw UnusableInput(where + ": has no [camera]; it is that of the run");
  }
  check_model_place(arguments.out);
  const ComponentMemory memory(configuration.parameters, where, {});
  Component& component = make_component(memory, configuration.parameters, where);
  start_from_checkpoint(
      arguments.checkpoint, arguments.checkpoint.string(), configuration.parameters, component);
  write_model_file(arguments.out, component);
}

std::string describe_model(const std::filesystem::path& file) {
  const Parameters parameters = with_some_camera();
  const ComponentMemory memory(parameters, file.string(), {});
  TargetModelFacts facts;
  const std::string refusal =
      load_model_file(file, &make_component(memory, parameters, file.string()), &facts);
  if (!refusal.empty()) {
    throw UnusableInput(fmt::format("{}: {}", file.string(), refusal));
  }
  return describe(facts);
}

void check_model(const std::filesystem::path& file) { fmt::print("{}", describe_model(file)); }

}  // namespace polhode::platform
