#include "initialisation/registration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace polhode {
namespace {

using Parameters = PatchTemplate::Parameters;
using Normal = Eigen::Matrix<double, PatchTemplate::kParameters, PatchTemplate::kParameters>;
constexpr int kGainAt = 6;  // of the parameters

// Weight by distance from the middle: a Gaussian with sigma 3 px, so that the place is that of the
// middle.
constexpr std::array<double, PatchTemplate::kHalf + 1> kWindow = {
    1.0, 0.945959, 0.800737, 0.606531, 0.411112, 0.249352};
// Blur by a Gaussian with sigma 0.7 px: interpolation changes finer detail with the place.
constexpr float kBlurMiddle = 0.58F;
constexpr float kBlurSide = 0.21F;
// Most settle within four steps; a fit that does not has no minimum.
constexpr int kIterationsMax = 12;
// An eighth of the least noise.
constexpr double kSettled_px = 0.01;
// Smaller over larger eigenvalue of the structure tensor: along an edge a place is undetermined.
constexpr double kCornerMin = 0.05;
// A patch that is five times darker or smaller is another one.
constexpr double kShrunkMin = 0.2;

double weight_of(int x, int y) {
  return kWindow[static_cast<std::size_t>(std::abs(x))] *
         kWindow[static_cast<std::size_t>(std::abs(y))];
}

/// Calls `visit(pixel, weight, x, y)`, x and y from the window's middle.
template <typename Visit>
void for_each_pixel(const Visit& visit) {
  std::size_t i = 0;
  for (int y = -PatchTemplate::kHalf; y <= PatchTemplate::kHalf; ++y) {
    for (int x = -PatchTemplate::kHalf; x <= PatchTemplate::kHalf; ++x) {
      visit(i++, weight_of(x, y), x, y);
    }
  }
}

/// Bilinear; false outside the crop.
bool level_at(const Crop& crop, float x, float y, float* level) {
  if (!(x >= 0.0F && y >= 0.0F && x < static_cast<float>(crop.width - 1) &&
        y < static_cast<float>(crop.height - 1))) {
    return false;
  }
  const auto left = static_cast<std::size_t>(x);
  const auto top = static_cast<std::size_t>(y);
  const auto width = static_cast<std::size_t>(crop.width);
  const std::uint8_t* const upper_row = &crop.levels[top * width + left];
  const std::uint8_t* const lower_row = upper_row + width;
  const float a = x - static_cast<float>(left);
  const float b = y - static_cast<float>(top);
  const auto upper_left = static_cast<float>(upper_row[0]);
  const auto lower_left = static_cast<float>(lower_row[0]);
  const float upper = upper_left + a * (static_cast<float>(upper_row[1]) - upper_left);
  const float lower = lower_left + a * (static_cast<float>(lower_row[1]) - lower_left);
  *level = upper + b * (lower - upper);
  return true;
}

/// Levels on a grid about a place, moved by an affine motion, then blurred. Row by row.
/// @return false where the grid leaves the crop.
template <std::size_t kGrid>
bool sample_blurred(const Crop& crop,
                    const Eigen::Matrix2d& affine,
                    const Eigen::Vector2d& place,
                    std::array<float, kGrid * kGrid>* out) {
  constexpr std::size_t kRaw = kGrid + 2;  // the blur needs one more on each side
  // From the middle.
  constexpr int kReach = static_cast<int>(kRaw) / 2;
  const Eigen::Matrix2f A = affine.cast<float>();
  const Eigen::Vector2f at = place.cast<float>();
  std::array<float, kRaw * kRaw> raw;
  std::size_t i = 0;
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      const auto dx = static_cast<float>(x);
      const auto dy = static_cast<float>(y);
      const float u = at.x() + A(0, 0) * dx + A(0, 1) * dy;
      const float v = at.y() + A(1, 0) * dx + A(1, 1) * dy;
      if (!level_at(crop, u, v, &raw[i++])) {
        return false;
      }
    }
  }
  std::array<float, kRaw * kGrid> across;
  for (std::size_t k = 0; k < across.size(); ++k) {
    const float* const p = &raw[k / kGrid * kRaw + k % kGrid];
    across[k] = kBlurSide * (p[0] + p[2]) + kBlurMiddle * p[1];
  }
  for (std::size_t k = 0; k < out->size(); ++k) {
    const float* const p = &across[k];
    (*out)[k] = kBlurSide * (p[0] + p[2 * kGrid]) + kBlurMiddle * p[kGrid];
  }
  return true;
}

bool has_corner(const Eigen::Matrix2d& tensor) {
  const double half_trace = 0.5 * tensor.trace();
  const double half_difference =
      std::sqrt(std::max(0.0, half_trace * half_trace - tensor.determinant()));
  return half_trace - half_difference > kCornerMin * (half_trace + half_difference);
}

using Levels = std::array<float, PatchTemplate::kPixels>;

/// Least-squares step of affine motion, gain and offset.
Parameters fit_levels(const PatchTemplate& patch, const Levels& levels) {
  Parameters gradient = Parameters::Zero();
  for_each_pixel([&](std::size_t i, double weight, int, int) {
    gradient += weight * static_cast<double>(levels[i]) * patch.derivatives[i];
  });
  return patch.inverse * gradient;
}

struct Motion {
  Eigen::Matrix2d affine;
  Eigen::Vector2d place;
};

/// Composes the inverse of the template's step with the motion.
/// @return the step's length; nothing where the fit makes no sense.
std::optional<double> compose(const Parameters& fit, Motion* motion) {
  const double gain = fit(kGainAt);
  if (!(gain > kShrunkMin)) {
    return std::nullopt;
  }
  Eigen::Matrix2d grown;
  grown << gain + fit(2), fit(3), fit(4), gain + fit(5);
  grown /= gain;
  if (!(grown.determinant() > kShrunkMin)) {
    return std::nullopt;
  }
  motion->affine = motion->affine * grown.inverse();
  const Eigen::Vector2d step = motion->affine * fit.head<2>() / gain;
  motion->place -= step;
  return step.norm();
}

Registration accepted_registration(const PatchTemplate& patch,
                                   const Levels& levels,
                                   const Parameters& fit,
                                   const Eigen::Vector2d& place) {
  double weights = 0.0;
  double mean = 0.0;
  double rest2 = 0.0;
  for_each_pixel([&](std::size_t i, double weight, int, int) {
    const auto level = static_cast<double>(levels[i]);
    const double rest = level - patch.derivatives[i].dot(fit);
    weights += weight;
    mean += weight * level;
    rest2 += weight * rest * rest;
  });
  mean /= weights;
  double of_image = 0.0;
  double of_template = 0.0;
  double of_both = 0.0;
  for_each_pixel([&](std::size_t i, double weight, int, int) {
    const double now = static_cast<double>(levels[i]) - mean;
    const double then = patch.derivatives[i](kGainAt);
    of_image += weight * now * now;
    of_template += weight * then * then;
    of_both += weight * now * then;
  });
  const double gain = fit(kGainAt);
  const double variance = rest2 / (weights - PatchTemplate::kParameters) / (gain * gain);
  return {.place = place,
          .sigma = std::sqrt(variance * std::max(patch.inverse(0, 0), patch.inverse(1, 1))),
          .zncc = of_both / std::sqrt(std::max(of_image * of_template, 1e-12))};
}

}  // namespace

bool make_template(const Crop& crop, const Eigen::Vector2d& place, PatchTemplate* patch) {
  constexpr std::size_t kWide = PatchTemplate::kSide + 2;  // derivatives need one more on each side
  std::array<float, kWide * kWide> wide;
  if (!sample_blurred<kWide>(crop, Eigen::Matrix2d::Identity(), place, &wide)) {
    return false;
  }
  const auto in_wide = [&](int x, int y) {
    // The pixel's index in the grid with its border.
    constexpr int kMiddle = PatchTemplate::kHalf + 1;
    return static_cast<double>(wide[static_cast<std::size_t>(y + kMiddle) * kWide +
                                    static_cast<std::size_t>(x + kMiddle)]);
  };
  double mean = 0.0;
  double weights = 0.0;
  for_each_pixel([&](std::size_t, double weight, int x, int y) {
    mean += weight * in_wide(x, y);
    weights += weight;
  });
  mean /= weights;
  Normal H = Normal::Zero();
  for_each_pixel([&](std::size_t i, double weight, int x, int y) {
    const double across = 0.5 * (in_wide(x + 1, y) - in_wide(x - 1, y));
    const double down = 0.5 * (in_wide(x, y + 1) - in_wide(x, y - 1));
    Parameters& J = patch->derivatives[i];
    J << across, down, across * x, across * y, down * x, down * y, in_wide(x, y) - mean, 1.0;
    H += weight * J * J.transpose();
  });
  if (!has_corner(H.topLeftCorner<2, 2>())) {
    return false;
  }
  patch->inverse = H.ldlt().solve(Normal::Identity());
  return patch->inverse.allFinite() && patch->inverse.diagonal().minCoeff() > 0.0;
}

std::optional<Registration> register_patch(const PatchTemplate& patch,
                                           const Crop& crop,
                                           const Eigen::Matrix2d& affine,
                                           const Eigen::Vector2d& place) {
  Motion motion{.affine = affine, .place = place};
  Levels levels;
  for (int iteration = 0; iteration < kIterationsMax; ++iteration) {
    if (!sample_blurred<PatchTemplate::kSide>(crop, motion.affine, motion.place, &levels)) {
      return std::nullopt;
    }
    const Parameters fit = fit_levels(patch, levels);
    const std::optional<double> step_px = compose(fit, &motion);
    if (!step_px) {
      return std::nullopt;
    }
    if (*step_px < kSettled_px) {
      return accepted_registration(patch, levels, fit, motion.place);
    }
  }
  return std::nullopt;
}

}  // namespace polhode
