#include "app/warnings.hpp"

#include <fmt/format.h>

#include "camera/lens_doubts.hpp"
#include "errors.hpp"
#include "tell.hpp"

namespace polhode::platform {

void tell_warnings(std::span<const std::string> warnings) {
  for (const std::string& warning : warnings) {
    tell("polhode: warning: {}\n", legible(warning));
  }
}

void judge_configured_camera(const std::filesystem::path& config, const CameraParameters& camera) {
  const std::string disorder = wrong_order(camera);
  if (!disorder.empty()) {
    throw UnusableInput(fmt::format("{}: [camera] {}", config.string(), disorder));
  }
  for (const std::string& doubt : doubts_about_lens(camera)) {
    tell("polhode: warning: {}: [camera] {}\n", legible(config.string()), doubt);
  }
}

}  // namespace polhode::platform
