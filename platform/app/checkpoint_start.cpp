#include "app/checkpoint_start.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>
#include <vector>

#include "app/checkpoint_file.hpp"
#include "errors.hpp"
#include "parameters/load.hpp"
#include "pipeline/checkpoint.hpp"
#include "pipeline/ground_view.hpp"
#include "print_stderr.hpp"

namespace polhode::platform {
namespace {

/// Keys of the parameters that are not the same.
std::vector<std::string> differing_keys(const Parameters& a, const Parameters& b) {
  std::istringstream of_a(canonical_text(a));
  std::istringstream of_b(canonical_text(b));
  std::vector<std::string> keys;
  std::string row_a;
  std::string row_b;
  while (std::getline(of_a, row_a) && std::getline(of_b, row_b)) {
    if (row_a != row_b) {
      keys.push_back(row_a.substr(0, row_a.find(' ')));
    }
  }
  return keys;
}

/// A checkpoint brings its run's parameters, as commands have left them.
void print_other_parameters(const std::string& named,
                            const Parameters& configured,
                            const Parameters& restored) {
  const std::vector<std::string> keys = differing_keys(configured, restored);
  for (const std::string& key : keys) {
    if (key.starts_with("camera.")) {
      throw UnusableInput(
          fmt::format("{}: was left by a run with another camera ({})", named, key));
    }
  }
  if (!keys.empty()) {
    print_stderr("polhode: {}: its parameters take the configuration's place: {}\n",
                 named,
                 fmt::join(keys, ", "));
  }
}

}  // namespace

void start_from_checkpoint(const std::filesystem::path& file,
                           const std::string& named,
                           const Parameters& configured,
                           Component& component) {
  LoadedCheckpoint loaded = load_whole_checkpoint(file, this_build());
  if (loaded.refusal.empty() && !restore_checkpoint(loaded.content, &component)) {
    loaded.refusal = "holds values that no run leaves";
  }
  if (!loaded.refusal.empty()) {
    throw UnusableInput(fmt::format("{}: {}", named, loaded.refusal));
  }
  print_other_parameters(named, configured, view_of(component).parameters);
}

}  // namespace polhode::platform
