#include "app/camera_check.hpp"

#include <fmt/format.h>

#include "geometry/camera_model.hpp"

namespace polhode::platform {
namespace {

/// The map was chosen with the stated one, and holds what is found back: it is a bound.
std::string contradiction(std::string_view name, std::string_view stated, std::string_view fits) {
  return fmt::format(
      "The pictures contradict the {}: {} is given, {}; attitudes, rates and all sigmas are in "
      "doubt.",
      name,
      stated,
      fits);
}

}  // namespace

std::vector<std::string> camera_sentences(const CameraFinding& found, const CameraModel& camera) {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < kDeviations; ++i) {
    const auto deviation = static_cast<Deviation>(i);
    if (!found.is(deviation) || deviation == Deviation::kPrincipalV) {
      continue;
    }
    const DeviationText is = describe(deviation, found, camera);
    if (deviation == Deviation::kPrincipalU) {
      const DeviationText v = describe(Deviation::kPrincipalV, found, camera);
      sentences.push_back(contradiction(is.name,
                                        fmt::format("{:.4g}, {:.4g}", is.stated, v.stated),
                                        fmt::format("{:.4g}, {:.4g} or beyond fits them, 1-sigma "
                                                    "{:.2g}, {:.2g}",
                                                    is.fits,
                                                    v.fits,
                                                    is.sigma,
                                                    v.sigma)));
      continue;
    }
    sentences.push_back(contradiction(is.name,
                                      fmt::format("{:.4g}", is.stated),
                                      fmt::format("{:.4g} or {} fits them, 1-sigma {:.2g}",
                                                  is.fits,
                                                  is.fits > is.stated ? "more" : "less",
                                                  is.sigma)));
  }
  return sentences;
}

}  // namespace polhode::platform
