// What over-exposure does to a scene's features, and what the controller saves: the frames of a
// sequence with truth in linear light, exposed anew from a twentieth to 32 times as much, once with
// that exposure throughout, once with it at the start and the controller afterwards. The noise is
// that of the sequence, scaled with its light; what is saturated there stays so. Usage:
// bench_exposure_scene SEQUENCE   (folder with mav0 and truth.csv, black background)
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <vector>

#include "features/workspace.hpp"
#include "mask/target_levels.hpp"
#include "true_frames.hpp"

namespace {

using namespace polhode;
using benchmark::TrueFrames;

constexpr std::array<double, 8> kExposures{0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0, 32.0};
constexpr double kGamma = 2.2;
constexpr double kUnit_s = 0.01;  // exposure that gives the sequence as it is

/// The response of the rendered scenes (tools/polhode_ground/scenes/sensor.py): a power law with a
/// straight foot. Light of 1 is full scale.
struct Response {
  static constexpr double kFoot = 0.004;
  static constexpr double kSlope = 6.0;
  static constexpr double kTop = kSlope * kFoot;

  static double light(double level) {
    return level < kTop ? level / kSlope
                        : kFoot + (1.0 - kFoot) * std::pow((level - kTop) / (1.0 - kTop), kGamma);
  }
  static double level(double light) {
    return light < kFoot
               ? kSlope * light
               : kTop + (1.0 - kTop) * std::pow((light - kFoot) / (1.0 - kFoot), 1.0 / kGamma);
  }
};

cv::Mat expose(const cv::Mat& gray, double exposure) {
  cv::Mat table(1, 256, CV_8UC1);
  for (int i = 0; i < 256; ++i) {
    const double light = std::min(1.0, exposure * Response::light(i / 255.0));
    table.at<std::uint8_t>(i) =
        static_cast<std::uint8_t>(std::lround(255.0 * Response::level(light)));
  }
  cv::Mat out;
  cv::LUT(gray, table, out);
  return out;
}

struct Outcome {
  double saturated = 0.0;  ///< part of the target's pixels, mean over frames
  double features = 0.0;   ///< a frame
  double right = 0.0;  ///< matches between neighbouring frames that lie on the true line, a pair
  double exposure_end = 0.0;
};

double saturated_part(const LevelCounts& counts) {
  constexpr std::ptrdiff_t kSaturated = 250;
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  return std::accumulate(counts.begin() + kSaturated, counts.end(), 0.0) / std::max(1.0, total);
}

Outcome run(const TrueFrames& frames, double start, bool controlled) {
  const auto workspace = std::make_unique<FeatureWorkspace>();
  auto before = std::make_unique<Features>();
  auto now = std::make_unique<Features>();
  const ExposureRange range{
      .exposure_min_s = 1e-5, .exposure_max_s = 1.0, .gain_max = 1.0, .response_gamma = kGamma};
  const MaskOptions options;
  Exposure exposure{.exposure_s = start * kUnit_s};
  Outcome outcome;
  for (std::size_t i = 0; i < frames.gray.size(); ++i) {
    const cv::Mat gray = expose(frames.gray[i], exposure.exposure_s / kUnit_s);
    TargetMask mask;
    find_target(gray, options, &mask);
    detect_features({&gray, &mask}, frames.camera, {}, workspace.get(), now.get());
    const LevelCounts levels = target_levels(gray, options, mask);
    outcome.saturated += saturated_part(levels);
    outcome.features += static_cast<double>(now->size());
    if (i > 0) {
      const auto judged = match_frames(frames, i - 1, i, *before, *now);
      outcome.right += static_cast<double>(judged.off_px.size());
    }
    std::swap(before, now);
    if (controlled) {
      exposure = next_exposure(levels, exposure, 0.0, range, {});
    }
  }
  const auto count = static_cast<double>(frames.gray.size());
  outcome.saturated /= count;
  outcome.features /= count;
  outcome.right /= std::max(1.0, count - 1.0);
  outcome.exposure_end = exposure.exposure_s / kUnit_s;
  return outcome;
}

void print(const Outcome& outcome) {
  std::printf("  | %5.1f %% %5.0f %5.0f %6.2f",
              100.0 * outcome.saturated,
              outcome.features,
              outcome.right,
              outcome.exposure_end);
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: bench_exposure_scene SEQUENCE\n");
    return 2;
  }
  const TrueFrames frames = benchmark::read_true_frames(words[1]);
  std::printf(
      "%s: %zu frames; each: saturated part of the target, features a frame, right matches "
      "a pair, exposure at the end\n",
      words[1],
      frames.gray.size());
  std::printf("exposure  | fixed                      | controlled\n");
  for (const double start : kExposures) {
    std::printf("%8.2f", start);
    print(run(frames, start, false));
    print(run(frames, start, true));
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}
