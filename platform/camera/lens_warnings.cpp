#include "camera/lens_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace polhode::platform {
namespace {

// Chosen, of an image's side. Sensors and lenses are centred to some per cent. A crop of a larger
// image may be farther off.
constexpr double kOffCentreMax = 0.15;
// Chosen: the pixels of cameras are squares, those of analogue video up to 1.1 wide.
constexpr double kPixelRatioMax = 1.2;
// Chosen: nothing wider is a pinhole with two radial coefficients; nothing narrower is on a
// spacecraft.
constexpr double kFieldMax_deg = 120.0;
constexpr double kFieldMin_deg = 0.1;

double ratio(double a, double b) { return std::max(a / b, b / a); }

double off_centre(double centre, int side) {
  return std::abs(centre - 0.5 * (side - 1)) / static_cast<double>(side);
}

double field_deg(int side, double focal) {
  return 2.0 * std::atan(0.5 * side / focal) * 180.0 / std::numbers::pi;
}

bool is_usual(const CameraParameters& c) {
  return ratio(c.fu_px, c.fv_px) < kPixelRatioMax &&
         off_centre(c.cu_px, c.width_px) < kOffCentreMax &&
         off_centre(c.cv_px, c.height_px) < kOffCentreMax;
}

bool looks_outside(const CameraParameters& c) {
  return c.cu_px < 0.0 || c.cu_px > c.width_px - 1.0 || c.cv_px < 0.0 ||
         c.cv_px > c.height_px - 1.0;
}

CameraParameters reordered(const CameraParameters& c, const std::array<double, 4>& fu_fv_cu_cv) {
  CameraParameters out = c;
  out.fu_px = fu_fv_cu_cv[0];
  out.fv_px = fu_fv_cu_cv[1];
  out.cu_px = fu_fv_cu_cv[2];
  out.cv_px = fu_fv_cu_cv[3];
  return out;
}

/// Does the principal point suit an image some times as large, and this one not?
double times_as_large(const CameraParameters& c) {
  const double by_width = (2.0 * c.cu_px + 1.0) / c.width_px;
  const double by_height = (2.0 * c.cv_px + 1.0) / c.height_px;
  constexpr double kAlike = 1.1;  // both sides of a scaled image, to a tenth
  const bool positive = by_width > 0.0 && by_height > 0.0;
  return positive && ratio(by_width, by_height) < kAlike ? 0.5 * (by_width + by_height) : 1.0;
}

std::string principal_point(const CameraParameters& c) {
  const double u = off_centre(c.cu_px, c.width_px);
  const double v = off_centre(c.cv_px, c.height_px);
  if (std::max(u, v) < kOffCentreMax) {
    return "";
  }
  const double times = times_as_large(c);
  const std::string hint =
      times > 1.0 + kOffCentreMax || times < 1.0 - kOffCentreMax
          ? fmt::format("; these look like the intrinsics of a picture {:.3g} times as large",
                        times)
          : "";
  return fmt::format(
      "intrinsics: the principal point ({:g}, {:g}) is {:.0f} % of the picture's side "
      "from its middle ({:g}, {:g}), usual are up to {:.0f} %{}",
      c.cu_px,
      c.cv_px,
      100.0 * std::max(u, v),
      0.5 * (c.width_px - 1),
      0.5 * (c.height_px - 1),
      100.0 * kOffCentreMax,
      hint);
}

std::string focal_lengths(const CameraParameters& c, double pixel_aspect) {
  if (ratio(pixel_aspect * c.fu_px, c.fv_px) < kPixelRatioMax) {
    return "";
  }
  return fmt::format(
      "intrinsics: fu {:g} and fv {:g} differ by a factor of {:.2f}{}, usual are up to "
      "{:g}; the order is fu, fv, cu, cv",
      c.fu_px,
      c.fv_px,
      ratio(pixel_aspect * c.fu_px, c.fv_px),
      pixel_aspect == 1.0 ? "" : fmt::format(" beside pixel_aspect {:g}", pixel_aspect),
      kPixelRatioMax);
}

std::string field_of_view(const CameraParameters& c) {
  const double field = field_deg(std::max(c.width_px, c.height_px), std::sqrt(c.fu_px * c.fv_px));
  if (field < kFieldMax_deg && field > kFieldMin_deg) {
    return "";
  }
  return fmt::format(
      "intrinsics: a field of view of {:.3g} deg (fu {:g} px, {} px wide), usual are "
      "{:g} .. {:g} deg",
      field,
      c.fu_px,
      c.width_px,
      kFieldMin_deg,
      kFieldMax_deg);
}

/// Where the radius in the image no longer grows with that of the ray, pixels have two rays.
std::string distortion(const CameraParameters& c) {
  constexpr int kSteps = 64;  // of the radius; coarse is enough for a polynomial of degree four
  constexpr double kFarthest = 4.0;  // a barrel shows rays that lie farther out than a pinhole's
  const double u = std::max(c.cu_px, c.width_px - 1.0 - c.cu_px) / c.fu_px;
  const double v = std::max(c.cv_px, c.height_px - 1.0 - c.cv_px) / c.fv_px;
  const double corner = std::hypot(u, v);
  for (int i = 1; i <= kSteps; ++i) {
    const double r = kFarthest * corner * i / kSteps;
    if (r * (1.0 + c.k1 * r * r + c.k2 * r * r * r * r) >= corner) {
      return "";  // points farther out are not in the image
    }
    if (1.0 + 3.0 * c.k1 * r * r + 5.0 * c.k2 * r * r * r * r <= 0.0) {
      return fmt::format(
          "distortion_coefficients: k1 {:g} and k2 {:g} fold the picture back at {:.0f} "
          "px from the principal point, inside the picture",
          c.k1,
          c.k2,
          r * (1.0 + c.k1 * r * r + c.k2 * r * r * r * r) * std::sqrt(c.fu_px * c.fv_px));
    }
  }
  return "";
}

}  // namespace

std::vector<std::string> lens_warnings(const CameraParameters& camera, double pixel_aspect) {
  std::vector<std::string> warnings;
  for (const std::string& warning : {principal_point(camera),
                                     focal_lengths(camera, pixel_aspect),
                                     field_of_view(camera),
                                     distortion(camera)}) {
    if (!warning.empty()) {
      warnings.push_back(warning);
    }
  }
  return warnings;
}

std::string wrong_order(const CameraParameters& c) {
  const std::array<double, 4> as_written = {c.fu_px, c.fv_px, c.cu_px, c.cv_px};
  if (!looks_outside(c)) {
    return "";
  }
  const auto& [a, b, d, e] = as_written;
  struct Order {
    const char* name;
    std::array<double, 4> fu_fv_cu_cv;
  };
  for (const Order& order :
       {Order{"fu, cu, fv, cv", {a, d, b, e}}, Order{"cu, cv, fu, fv", {d, e, a, b}}}) {
    if (is_usual(reordered(c, order.fu_fv_cu_cv))) {
      return fmt::format(
          "intrinsics: {:g}, {:g}, {:g}, {:g} make no camera of {}x{} px in the order "
          "fu, fv, cu, cv; allowed is this order, and they look like {}",
          a,
          b,
          d,
          e,
          c.width_px,
          c.height_px,
          order.name);
    }
  }
  return "";
}

}  // namespace polhode::platform
