#include "app/camera_check.hpp"

#include <fmt/format.h>

#include <cmath>

namespace polhode::platform {
namespace {

/// The map was chosen with the stated one, and holds what is found back: it is a bound.
std::string contradiction(std::string_view what,
                          std::string_view unit,
                          double stated,
                          double fits,
                          double sigma) {
  return fmt::format(
      "The pictures contradict the {}: {:.4g}{} is given, {:.4g}{} or {} fits them, 1-sigma {:.2g}; "
      "attitudes, rates and all sigmas are in doubt.",
      what,
      stated,
      unit,
      fits,
      unit,
      fits > stated ? "more" : "less",
      sigma);
}

}  // namespace

std::vector<std::string> camera_sentences(const CameraFinding& found,
                                          const CameraParameters& c) {
  std::vector<std::string> sentences;
  const auto say = [&](Deviation deviation,
                       std::string_view what,
                       std::string_view unit,
                       double stated,
                       double fits,
                       double by_value) {
    if (found.is(deviation)) {
      sentences.push_back(
          contradiction(what, unit, stated, fits, by_value * found.sigma_of(deviation)));
    }
  };
  const auto times = [&](Deviation deviation) { return std::exp(found.of(deviation)); };
  const double focal_px = std::sqrt(c.fu_px * c.fv_px);
  const double ratio = c.fv_px / c.fu_px;
  const double focal_found_px = focal_px * times(Deviation::kFocal);
  say(Deviation::kFocal, "focal length", " px", focal_px, focal_found_px, focal_found_px);
  say(Deviation::kZoom, "one focal length of all images (last over first)", "", 1.0,
      times(Deviation::kZoom), times(Deviation::kZoom));
  say(Deviation::kAspect, "ratio fv / fu", "", ratio, ratio * times(Deviation::kAspect),
      ratio * times(Deviation::kAspect));
  say(Deviation::kPrincipalU, "principal point's u", " px", c.cu_px,
      c.cu_px + c.fu_px * found.of(Deviation::kPrincipalU), c.fu_px);
  say(Deviation::kPrincipalV, "principal point's v", " px", c.cv_px,
      c.cv_px + c.fv_px * found.of(Deviation::kPrincipalV), c.fv_px);
  say(Deviation::kReadout, "one time of all rows (last minus first)", " ms", 0.0,
      1e3 * found.of(Deviation::kReadout), 1e3);
  say(Deviation::kHalf, "one time of both halves of an image (lower minus upper)", " ms", 0.0,
      1e3 * found.of(Deviation::kHalf), 1e3);
  return sentences;
}

}  // namespace polhode::platform
