#include "app/check.hpp"

#include <fmt/format.h>

#include "app/machine_needs.hpp"
#include "app/scale_frame.hpp"
#include "camera/replay/sequence.hpp"
#include "errors.hpp"
#include "memory_plan.hpp"
#include "network/loaded_network.hpp"
#include "parameters/load.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/print.hpp"
#include "parameters/sha256.hpp"
#include "parameters/transport_options.hpp"
#include "pipeline/component.hpp"
#include "pipeline/parameter_table.hpp"

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

}  // namespace

void check_configuration(const CheckArguments& arguments) {
  if (arguments.defaults) {
    fmt::print("{}", documented_defaults());
    return;
  }
  Configuration configuration = load_configuration(arguments.config, arguments.settings);
  const MachineOptions machine = load_machine_options(arguments.config, arguments.settings);
  const TransportOptions transport =
      load_transport_options(arguments.config, arguments.settings);
  const LoadedNetwork network(transport.network_file);
  std::string frames;
  if (!arguments.sequence.empty()) {
    const Sequence sequence = open_sequence(arguments.sequence);
    take_camera(sequence, configuration);
    if (const auto problem = check(configuration.parameters)) {
      throw UnusableInput(fmt::format("{}: {}", arguments.config.string(), problem->message));
    }
    check_scale_frame(configuration, sequence);
    frames =
        fmt::format("sequence: {} frames in {}\n", sequence.frames.size(), sequence.path.string());
  }
  fmt::print("{}\n{}config hash: {}\n",
             effective_table(configuration),
             frames,
             sha256_of(canonical_text(configuration.parameters)));
  if (arguments.memory && !configuration.has_camera) {
    throw UnusableInput(fmt::format(
        "{}: the memory depends on the camera's size: give --sequence, or a section [camera]",
        arguments.config.string()));
  }
  if (configuration.has_camera) {
    const MemoryPlan plan =
        plan_memory(configuration.parameters,
                    live_needs(machine, transport, configuration.parameters.camera));
    fmt::print("memory of the component: {} octets; in all: {} of {}\n",
               plan.tables_octets,
               plan.total_octets,
               plan.limit_octets);
    if (arguments.memory) {
      fmt::print("\n{}", text_of(plan));
    }
    if (!plan.problem.empty()) {
      throw UnusableInput(fmt::format(
          "{}: the memory does not fit: {}", arguments.config.string(), plan.problem));
    }
  }
}

}  // namespace polhode::platform
