#include "tracks/optical_flow.hpp"

#include <opencv2/video/tracking.hpp>

#include "base/assert.hpp"

namespace polhode {
namespace {

// OpenCV's defaults. Half a patch on the top level, halved three times, is a motion of 80 px: more
// than the default of small_motion_max_px.
constexpr int kLevels = 3;
constexpr int kPatch_px = 21;

cv::TermCriteria stop_rule() {
  // OpenCV's defaults.
  constexpr int kIterations = 30;
  constexpr double kStep_px = 0.01;
  return {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kIterations, kStep_px};
}

void flow(const Pyramid& before,
          const Pyramid& now,
          const std::vector<cv::Point2f>& from,
          std::vector<cv::Point2f>* to,
          std::vector<std::uint8_t>* found) {
  std::vector<float> error;
  // Least eigenvalue of the patch's gradient matrix, per pixel: below it the patch has no corner.
  // OpenCV's default.
  constexpr double kEigenvalueMin = 1e-4;
  cv::calcOpticalFlowPyrLK(before.levels,
                           now.levels,
                           from,
                           *to,
                           *found,
                           error,
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
  POLHODE_ASSERT(from.size() == guess.size(), from.size());
  if (from.empty()) {
    return;
  }
  std::vector<cv::Point2f> start;
  std::vector<cv::Point2f> end;
  for (std::size_t i = 0; i < from.size(); ++i) {
    start.emplace_back(from[i].u_px, from[i].v_px);
    end.emplace_back(guess[i].u_px, guess[i].v_px);
  }
  std::vector<std::uint8_t> found;
  flow(before, now, start, &end, &found);
  std::vector<cv::Point2f> back = start;
  std::vector<std::uint8_t> found_back;
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
