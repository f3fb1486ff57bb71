#include "app/check.hpp"

#include <fmt/format.h>

#include "camera/replay/sequence.hpp"
#include "errors.hpp"
#include "parameters/load.hpp"
#include "parameters/print.hpp"
#include "parameters/sha256.hpp"
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
  std::string frames;
  if (!arguments.sequence.empty()) {
    const Sequence sequence = open_sequence(arguments.sequence);
    take_camera(sequence, configuration);
    if (const auto problem = check(configuration.parameters)) {
      throw UnusableInput(fmt::format("{}: {}", arguments.config.string(), problem->message));
    }
    frames =
        fmt::format("sequence: {} frames in {}\n", sequence.frames.size(), sequence.path.string());
  }
  fmt::print("{}\n{}config hash: {}\n",
             effective_table(configuration),
             frames,
             sha256_of(canonical_text(configuration.parameters)));
  if (configuration.has_camera) {
    fmt::print("memory of the component: {} octets\n",
               memory_needed(configuration.parameters).total);
  }
}

}  // namespace polhode::platform
