#include "tracks/optical_flow.hpp"

#include <opencv2/video/tracking.hpp>

#include "base/assert.hpp"
#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

// OpenCV's defaults. Half a patch on the top level, halved three times, is a motion of 80 px: more
// than the default of small_motion_max_px.
constexpr int kLevels = 3;
constexpr int kPatch_px = 21;

using FlowPoints = FixedVector<cv::Point2f, limits::kPoseMatches>;

cv::TermCriteria stop_rule() {
  // OpenCV's defaults.
  constexpr int kIterations = 30;
  constexpr double kStep_px = 0.01;
  return {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kIterations, kStep_px};
}

void flow(const Pyramid& before,
          const Pyramid& now,
          const FlowPoints& from,
          FlowPoints* to,
          FixedVector<std::uint8_t, limits::kPoseMatches>* found) {
  FixedVector<float, limits::kPoseMatches> error;
  error.resize(from.size());
  found->resize(from.size());
  const auto count = static_cast<int>(from.size());
  cv::Mat to_px(count, 1, CV_32FC2, to->begin());
  cv::Mat is_found(count, 1, CV_8UC1, found->begin());
  cv::Mat error_levels(count, 1, CV_32FC1, error.begin());
  // Least eigenvalue of the patch's gradient matrix, per pixel: below it the patch has no corner.
  // OpenCV's default.
  constexpr double kEigenvalueMin = 1e-4;
  cv::calcOpticalFlowPyrLK(before.levels,
                           now.levels,
                           cv::_InputArray(from.begin(), count),
                           to_px,
                           is_found,
                           error_levels,
                           cv::Size(kPatch_px, kPatch_px),
                           kLevels,
                           stop_rule(),
                           cv::OPTFLOW_USE_INITIAL_FLOW,
                           kEigenvalueMin);
}

}  // namespace

void build_pyramid(const cv::Mat& gray, Pyramid* pyramid) {
  // Without gradients, which would take four times the levels' memory in both pyramids.
  constexpr bool kWithGradients = false;
  cv::buildOpticalFlowPyramid(
      gray, pyramid->levels, cv::Size(kPatch_px, kPatch_px), kLevels, kWithGradients);
  pyramid->built = true;
}

void follow_points(const Pyramid& before,
                   const Pyramid& now,
                   std::span<const FlowPoint> from,
                   const TrackOptions& options,
                   std::span<FlowPoint> guess) {
  POLHODE_ASSERT(from.size() == guess.size() && from.size() <= limits::kPoseMatches, from.size());
  if (from.empty()) {
    return;
  }
  FlowPoints start;
  FlowPoints end;
  for (std::size_t i = 0; i < from.size(); ++i) {
    (void)start.push_back({from[i].u_px, from[i].v_px});
    (void)end.push_back({guess[i].u_px, guess[i].v_px});
  }
  FixedVector<std::uint8_t, limits::kPoseMatches> found;
  flow(before, now, start, &end, &found);
  FlowPoints back = start;
  FixedVector<std::uint8_t, limits::kPoseMatches> found_back;
  flow(now, before, end, &back, &found_back);
  const double limit2 = options.forward_backward_max_px * options.forward_backward_max_px;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const cv::Point2f d = back[i] - start[i];
    const bool returned = static_cast<double>(d.x * d.x + d.y * d.y) <= limit2;
    guess[i] = {.u_px = end[i].x,
                .v_px = end[i].y,
                .followed = found[i] != 0 && found_back[i] != 0 && returned};
  }
}

}  // namespace polhode
