#include "app/check.hpp"

#include <fmt/format.h>

#include <optional>

#include "app/machine_needs.hpp"
#include "app/model_command.hpp"
#include "app/own_structure_file.hpp"
#include "app/places.hpp"
#include "app/scale_frame.hpp"
#include "app/warnings.hpp"
#include "camera/replay/sequence.hpp"
#include "errors.hpp"
#include "memory_plan.hpp"
#include "parameters/bus_parameters.hpp"
#include "parameters/load.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/print.hpp"
#include "parameters/sha256.hpp"
#include "parameters/transport_options.hpp"
#include "pipeline/component.hpp"
#include "pipeline/parameter_table.hpp"
#include "transport/command_file.hpp"

namespace polhode::platform {
namespace {

void take_camera(const Sequence& sequence, Configuration& configuration) {
  configuration.parameters.camera = sequence.camera;
  configuration.has_camera = true;
  std::size_t index = 0;
  for (const ParameterRow& row : parameter_table()) {
    if (row.key.substr(0, 7) == "camera.") {
      configuration.origins[index] = "sensor.yaml";
    }
    ++index;
  }
}

std::optional<Sequence> take_sequence(const CheckArguments& arguments,
                                      Configuration& configuration) {
  if (arguments.sequence.empty()) {
    if (configuration.has_camera) {
      check_configured_camera(arguments.config, configuration.parameters.camera);
    }
    return std::nullopt;
  }
  Sequence sequence = open_sequence(arguments.sequence);
  print_warnings(sequence.warnings);
  take_camera(sequence, configuration);
  if (const auto problem = check(configuration.parameters)) {
    throw UnusableInput(fmt::format("{}: {}", arguments.config.string(), problem->message));
  }
  check_scale_frame(configuration, sequence);
  return sequence;
}

std::string about(const std::optional<Sequence>& sequence) {
  return sequence
             ? fmt::format(
                   "sequence: {} frames in {}\n", sequence->frames.size(), sequence->path.string())
             : std::string();
}

/// The files that are named, as a replay or a run opens them.
void check_files(const CheckArguments& arguments,
                 const MachineOptions& machine,
                 const TransportOptions& transport,
                 const Parameters& parameters) {
  check_places(arguments.config, machine);
  if (!machine.run.model.empty()) {
    named("run.model", [&] { (void)describe_model(machine.run.model); });
  }
  (void)key_of(transport.transport.commands);
  if (!transport.commands_file.empty()) {
    const CommandFile commands(transport.commands_file, parameters.bus.apid_first);
  }
}

void check_memory(const CheckArguments& arguments,
                  const Configuration& configuration,
                  const MachineNeeds& needs) {
  const MemoryPlan plan = plan_memory(configuration.parameters, needs);
  fmt::print("memory of the component: {} octets; in all: {} of {}\n",
             plan.tables_bytes,
             plan.total_bytes,
             plan.limit_bytes);
  if (arguments.memory) {
    fmt::print("\n{}", text_of(plan));
  }
  if (!plan.problem.empty()) {
    throw UnusableInput(
        fmt::format("{}: the memory does not fit: {}", arguments.config.string(), plan.problem));
  }
}

}  // namespace

void check_configuration(const CheckArguments& arguments) {
  if (arguments.defaults) {
    fmt::print("{}", documented_defaults());
    return;
  }
  if (arguments.bus_parameters) {
    fmt::print("{}", bus_parameters());
    return;
  }
  Configuration configuration = load_configuration(arguments.config, arguments.settings);
  const MachineOptions machine = load_machine_options(arguments.config, arguments.settings);
  const TransportOptions transport =
      load_live_transport_options(arguments.config, arguments.settings);
  check_files(arguments, machine, transport, configuration.parameters);
  const std::optional<Sequence> sequence = take_sequence(arguments, configuration);
  if (configuration.has_camera) {
    const OwnStructureFile own(transport.own_structure_file, configuration.parameters.camera);
  }
  fmt::print("{}{}{}\n{}config hash: {}\n",
             effective_table(configuration),
             machine_table(machine),
             transport_table(transport),
             about(sequence),
             sha256_of(canonical_text(configuration.parameters)));
  if (configuration.has_camera) {
    MachineNeeds needs = live_needs(machine, transport, configuration.parameters.camera);
    if (sequence) {
      add_sequence(*sequence, &needs);
    }
    check_memory(arguments, configuration, needs);
  } else if (arguments.memory) {
    throw UnusableInput(fmt::format(
        "{}: the memory depends on the camera's size: give --sequence, or a section [camera]",
        arguments.config.string()));
  }
}

}  // namespace polhode::platform
