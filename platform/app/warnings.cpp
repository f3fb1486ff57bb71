#include "app/warnings.hpp"

#include <fmt/format.h>

#include "camera/lens_warnings.hpp"
#include "errors.hpp"
#include "print_stderr.hpp"

namespace polhode::platform {

void print_warnings(std::span<const std::string> warnings) {
  for (const std::string& warning : warnings) {
    print_stderr("polhode: warning: {}\n", legible(warning));
  }
}

void check_configured_camera(const std::filesystem::path& config, const CameraParameters& camera) {
  const std::string disorder = wrong_order(camera);
  if (!disorder.empty()) {
    throw UnusableInput(fmt::format("{}: [camera] {}", config.string(), disorder));
  }
  for (const std::string& warning : lens_warnings(camera)) {
    print_stderr("polhode: warning: {}: [camera] {}\n", legible(config.string()), warning);
  }
}

}  // namespace polhode::platform
