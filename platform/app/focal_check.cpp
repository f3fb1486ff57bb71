#include "app/focal_check.hpp"

#include <fmt/format.h>

#include <cmath>

namespace polhode::platform {

std::string focal_sentence(const FocalReport& found, const CameraParameters& camera) {
  if (!refutes_focal(found)) {
    return "";
  }
  const double given_px = std::sqrt(camera.fu_px * camera.fv_px);
  // The map was chosen with the given one, and holds what is found back: it is a bound.
  return fmt::format(
      "The pictures contradict the focal length: {:.4g} px is given, {:.4g} px or {} "
      "fits them; attitudes, rates and all sigmas are in doubt.",
      given_px,
      given_px * found.factor,
      found.factor > 1.0 ? "more" : "less");
}

}  // namespace polhode::platform
