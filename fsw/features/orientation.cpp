#include "features/orientation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "features/patch.hpp"

namespace polhode::sift {
namespace {

// Lowe, section 5: bins of 10 deg, weighted by a Gaussian of 1.5 times the blob's sigma.
constexpr int kBins = 36;
constexpr float kOrientationWindow = 1.5F;
// Half side of the patch, in the blob's sigma: three sigma of the weights.
constexpr float kReach = 3.0F * kOrientationWindow;
// Samples along a side of the patch: one for each 0.75 sigma. Chosen; a multiple of four lanes.
constexpr int kOrientationSide = 12;

using AngleHistogram = std::array<float, kBins>;

/// Weights along one axis of the patch. A sample's weight is that of its row times its column's.
std::array<float, kOrientationSide> window() {
  std::array<float, kOrientationSide> weight{};
  for (int i = 0; i < kOrientationSide; ++i) {
    const double off =
        (i - 0.5 * (kOrientationSide - 1)) * 2.0 * static_cast<double>(kReach) / kOrientationSide;
    weight[static_cast<std::size_t>(i)] = static_cast<float>(
        std::exp(-0.5 * off * off / static_cast<double>(kOrientationWindow * kOrientationWindow)));
  }
  return weight;
}

void accumulate_angles(const Gradients<kOrientationSide>& gradients, AngleHistogram* histogram) {
  static const std::array<float, kOrientationSide> kWeight = window();
  constexpr float kBinsPerRad = 0.5F * kBins / std::numbers::pi_v<float>;  // 36 bins a circle
  std::array<float, kBins + 2> sum{};
  for (std::size_t j = 0; j < kOrientationSide; ++j) {
    for (std::size_t i = 0; i < kOrientationSide; ++i) {
      const std::size_t k = j * kOrientationSide + i;
      const float weight = kWeight[i] * kWeight[j] * gradients.length[k];
      const float at = gradients.angle_rad[k] * kBinsPerRad;
      const auto bin = static_cast<std::size_t>(at);  // up to kBins, by rounding of 2 pi
      const float share = at - static_cast<float>(bin);
      sum[bin] += weight * (1.0F - share);
      sum[bin + 1] += weight * share;
    }
  }
  sum[0] += sum[kBins];
  sum[1] += sum[kBins + 1];
  std::copy_n(sum.begin(), kBins, histogram->begin());
}

/// Binomial weights, as OpenCV's SIFT.
AngleHistogram smoothed(const AngleHistogram& h) {
  const auto at = [&](std::size_t i) { return h[i % kBins]; };
  AngleHistogram out{};
  for (std::size_t i = 0; i < kBins; ++i) {
    out[i] = (at(i + kBins - 2) + at(i + 2)) * (1.0F / 16.0F) +
             (at(i + kBins - 1) + at(i + 1)) * (4.0F / 16.0F) + h[i] * (6.0F / 16.0F);
  }
  return out;
}

}  // namespace

void find_orientations(const Plane& level, float x, float y, float sigma_px, Orientations* out) {
  Gradients<kOrientationSide> gradients;
  sample_gradients(
      level, {.x = x, .y = y, .step_x = 2.0F * kReach / kOrientationSide * sigma_px}, &gradients);
  AngleHistogram raw{};
  accumulate_angles(gradients, &raw);
  const AngleHistogram h = smoothed(raw);
  constexpr float kPeakRatio = 0.8F;  // Lowe, section 5
  const float threshold = kPeakRatio * *std::max_element(h.begin(), h.end());
  out->clear();
  for (std::size_t i = 0; i < kBins; ++i) {
    const float before = h[(i + kBins - 1) % kBins];
    const float after = h[(i + 1) % kBins];
    if (h[i] > before && h[i] > after && h[i] >= threshold) {
      const float bin =
          static_cast<float>(i) + 0.5F * (before - after) / (before - 2.0F * h[i] + after);
      constexpr float kTurn = 2.0F * std::numbers::pi_v<float>;  // full circle
      const float angle_rad = bin * kTurn / kBins;
      (void)out->push_back(angle_rad < 0.0F ? angle_rad + kTurn : angle_rad);
    }
  }
}

}  // namespace polhode::sift
