#include "app/camera_check.hpp"

#include <fmt/format.h>

#include "geometry/camera_model.hpp"

namespace polhode::platform {

std::vector<std::string> camera_sentences(const CameraFinding& found, const CameraModel& camera) {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < kDeviations; ++i) {
    if (found.contradicted[i] != 0) {
      const DeviationTold is = told(static_cast<Deviation>(i), found, camera);
      // The map was chosen with the stated one, and holds what is found back: it is a bound.
      sentences.push_back(fmt::format(
          "The pictures contradict the {}: {:.4g} is given, {:.4g} or {} fits them, 1-sigma "
          "{:.2g}; attitudes, rates and all sigmas are in doubt.",
          is.name,
          is.stated,
          is.fits,
          is.fits > is.stated ? "more" : "less",
          is.sigma));
    }
  }
  return sentences;
}

}  // namespace polhode::platform
