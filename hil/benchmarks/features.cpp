// Features against OpenCV's on sequences with truth: how many pairs of spots are found again, how
// many of the matches lie on the true epipolar line, how near to it, and what a frame costs. Usage:
// bench_features SEQUENCE...   (folders with mav0 and truth.csv)
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "features/workspace.hpp"
#include "opencv_sift.hpp"
#include "true_frames.hpp"

namespace {

using namespace polhode;
using benchmark::JudgedMatches;
using benchmark::TrueFrames;

constexpr std::array<std::size_t, 3> kGaps{1, 2, 3};  // frames between the two of a pair

/// Processor time, seconds.
double now_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Tally {
  int matches = 0;
  int pairs = 0;
  std::vector<double> off_px;  ///< of the right matches
};

struct Outcome {
  double detect_s = 0.0;
  double features = 0.0;
  std::array<Tally, kGaps.size()> of_gap;
};

using Detect = void (*)(
    const cv::Mat&, const TargetMask&, const CameraModel&, const FeatureOptions&, Features*);

void detect_own(const cv::Mat& gray,
                const TargetMask& mask,
                const CameraModel& camera,
                const FeatureOptions& options,
                Features* features) {
  static const auto workspace = std::make_unique<FeatureWorkspace>();
  detect_features({&gray, &mask}, camera, options, workspace.get(), features);
}

Outcome run(const TrueFrames& frames, Detect detect) {
  Outcome outcome;
  std::vector<std::unique_ptr<Features>> found;
  for (const cv::Mat& gray : frames.gray) {
    TargetMask mask;
    find_target(gray, {}, &mask);
    found.push_back(std::make_unique<Features>());
    const double begin_s = now_s();
    detect(gray, mask, frames.camera, {}, found.back().get());
    outcome.detect_s += now_s() - begin_s;
    outcome.features += static_cast<double>(found.back()->size());
  }
  for (std::size_t g = 0; g < kGaps.size(); ++g) {
    for (std::size_t a = 0; a + kGaps[g] < found.size(); a += 2) {
      const std::size_t b = a + kGaps[g];
      const JudgedMatches judged = match_frames(frames, a, b, *found[a], *found[b]);
      Tally& tally = outcome.of_gap[g];
      ++tally.pairs;
      tally.matches += judged.matches;
      tally.off_px.insert(tally.off_px.end(), judged.off_px.begin(), judged.off_px.end());
    }
  }
  return outcome;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return NAN;
  }
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

void print(const char* name, const TrueFrames& frames, const Outcome& outcome) {
  const auto count = static_cast<double>(frames.gray.size());
  std::printf("  %-7s %6.1f ms %5.0f features;",
              name,
              1e3 * outcome.detect_s / count,
              outcome.features / count);
  for (std::size_t g = 0; g < kGaps.size(); ++g) {
    const Tally& t = outcome.of_gap[g];
    std::printf("  +%zu: %5.1f %3.0f%% %.3f %.3f",
                kGaps[g],
                static_cast<double>(t.off_px.size()) / std::max(1, t.pairs),
                100.0 * static_cast<double>(t.off_px.size()) / std::max(1, t.matches),
                quantile(t.off_px, 0.5),
                quantile(t.off_px, 0.8));
  }
  std::printf("\n");
}

}  // namespace

int main(int count, char** words) {
  std::printf(
      "per gap of frames: right matches a pair, right of all, median and 80 %% distance from the "
      "line, px\n");
  for (int i = 1; i < count; ++i) {
    const TrueFrames frames = benchmark::read_true_frames(words[i]);
    std::printf("%s: %zu frames\n", words[i], frames.gray.size());
    print("opencv", frames, run(frames, benchmark::detect_features_opencv));
    print("own", frames, run(frames, detect_own));
  }
  return 0;
}
