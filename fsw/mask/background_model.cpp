#include "mask/background_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "mask/outline.hpp"
#include "mask/plane_motion.hpp"

namespace polhode {
namespace {

// Votes of a known place. With 8, overlaps are within 0.006 (decision 0014).
constexpr int kVotesKnown = 4;
// Most votes: 13 images in a row that differ make a long known place unknown. Chosen; larger adapts
// to changes of the room later, smaller takes a passing shadow for one.
constexpr int kVotesMost = 16;

int tolerance_of(double noise) {
  constexpr double kSigmas = 3.0;                             // 99.7 % of a normal distribution
  return static_cast<int>(std::lround(kSigmas * noise)) + 1;  // a level for the median's own error
}

}  // namespace

bool stands_still(const BackgroundState& background, const cv::Size& size) {
  constexpr double kStill_px = 0.5;  // so that pixels stay the same ones (decision 0014)
  const auto right = static_cast<float>(size.width);
  const auto bottom = static_cast<float>(size.height);
  const std::array<cv::Point2f, 4> corners{
      cv::Point2f(0.0F, 0.0F), {right, 0.0F}, {right, bottom}, {0.0F, bottom}};
  for (const BackgroundMotion& motion : background.motions) {
    for (const cv::Matx33d& layer : motion.layers) {
      if (std::all_of(corners.begin(), corners.end(), [&](const cv::Point2f& corner) {
            return cv::norm(moved(layer, corner) - corner) < kStill_px;
          })) {
        return true;
      }
    }
  }
  return false;
}

void learn_background(const cv::Mat& image,
                      const cv::Mat& outline,
                      double noise,
                      BackgroundModel* model) {
  if (model->level.size() != image.size()) {
    image.copyTo(model->level);
    model->votes.create(image.size(), CV_8UC1);
    model->votes.setTo(0);
  }
  constexpr int kSide = 2 * kOutlineOff_px + 1;  // that far on both sides of a pixel
  cv::Mat& closed_places = model->matches;
  cv::dilate(outline, closed_places, cv::Mat::ones(kSide, kSide, CV_8UC1));
  const int tolerance = tolerance_of(noise);
  for (int row = 0; row < image.rows; ++row) {
    const auto* now = image.ptr<std::uint8_t>(row);
    const auto* closed = closed_places.ptr<std::uint8_t>(row);
    auto* level = model->level.ptr<std::uint8_t>(row);
    auto* votes = model->votes.ptr<std::uint8_t>(row);
    for (int column = 0; column < image.cols; ++column) {
      if (closed[column] != 0) {
        continue;
      }
      const int step = now[column] - level[column];
      if (std::abs(step) <= tolerance) {
        // One level at a time, up as often as down: this converges to the median.
        level[column] =
            static_cast<std::uint8_t>(level[column] + (step > 0 ? 1 : 0) - (step < 0 ? 1 : 0));
        votes[column] = static_cast<std::uint8_t>(std::min(votes[column] + 1, kVotesMost));
      } else if (votes[column] > 0) {
        --votes[column];
      } else {
        level[column] = now[column];
      }
    }
  }
}

void match_background(const cv::Mat& image, double noise, BackgroundModel* model) {
  model->matches.create(image.size(), CV_8UC1);
  model->matches.setTo(0);
  if (model->level.size() != image.size()) {
    return;
  }
  const int tolerance = tolerance_of(noise);
  for (int row = 0; row < image.rows; ++row) {
    const auto* now = image.ptr<std::uint8_t>(row);
    const auto* level = model->level.ptr<std::uint8_t>(row);
    const auto* votes = model->votes.ptr<std::uint8_t>(row);
    auto* match = model->matches.ptr<std::uint8_t>(row);
    for (int column = 0; column < image.cols; ++column) {
      const bool same = std::abs(now[column] - level[column]) <= tolerance;
      match[column] = votes[column] >= kVotesKnown && same ? 255 : 0;
    }
  }
  cv::medianBlur(model->matches, model->matches, 3);  // single pixels are chance
}

void clear(BackgroundModel* model) {
  if (!model->votes.empty()) {
    model->votes.setTo(0);
  }
}

}  // namespace polhode
