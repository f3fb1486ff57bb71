// Images of a textured disc before a textured background, each with a motion of its own.
#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"

namespace polhode::moving {

inline constexpr int kWidth = 320;
inline constexpr int kHeight = 240;

/// Smooth random texture, 60 .. 200.
inline cv::Mat texture(int side, std::uint64_t seed) {
  cv::Mat noise(side, side, CV_32FC1);
  Rng rng(seed, 0);
  for (int v = 0; v < side; ++v) {
    for (int u = 0; u < side; ++u) {
      noise.at<float>(v, u) = static_cast<float>(rng.uniform());
    }
  }
  cv::Mat smooth;
  cv::GaussianBlur(noise, smooth, cv::Size(0, 0), 2.0);
  cv::normalize(smooth, smooth, 60.0, 200.0, cv::NORM_MINMAX);
  cv::Mat out;
  smooth.convertTo(out, CV_8UC1);
  return out;
}

struct Scene {
  cv::Point2d background_px{0.0, 0.0};  ///< motion a frame
  cv::Point2d target_px{0.0, 0.0};
  double target_turn_deg = 0.0;  ///< a frame, about the line of sight
  double radius_px = 40.0;
  cv::Point2d start_px{160.0, 120.0};
  int horizon_row = 0;  ///< above it there is nothing behind the target
  bool background = true;
  bool target = true;
  double noise = 1.5;

  cv::Mat behind = texture(900, 1);
  cv::Mat skin = texture(300, 2);

  [[nodiscard]] cv::Point2d centre(int frame) const { return start_px + frame * target_px; }

  [[nodiscard]] cv::Mat truth(int frame) const {
    cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(0));
    if (target) {
      cv::circle(
          mask, cv::Point(centre(frame)), static_cast<int>(radius_px), cv::Scalar(255), cv::FILLED);
    }
    return mask;
  }

  [[nodiscard]] cv::Mat image(int frame) const {
    cv::Mat gray(kHeight, kWidth, CV_8UC1, cv::Scalar(0));
    if (background) {
      const cv::Matx23d move(
          1, 0, -250 + frame * background_px.x, 0, 1, -250 + frame * background_px.y);
      cv::warpAffine(behind, gray, move, gray.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
      gray.rowRange(0, horizon_row).setTo(0);
    }
    if (target) {
      cv::Mat turned;
      const cv::Point2d c = centre(frame);
      cv::Matx23d turn =
          cv::Matx23d(cv::getRotationMatrix2D(cv::Point2f(150, 150), frame * target_turn_deg, 1.0));
      turn(0, 2) += c.x - 150.0;
      turn(1, 2) += c.y - 150.0;
      cv::warpAffine(skin, turned, turn, gray.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
      turned.copyTo(gray, truth(frame));
    }
    Rng rng(7, static_cast<std::uint64_t>(frame));
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const double level = gray.data[i] + (gray.data[i] > 0 ? noise * rng.normal() : 0.0);
      gray.data[i] = cv::saturate_cast<std::uint8_t>(level);
    }
    return gray;
  }
};

inline double overlap(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<double>(cv::countNonZero(a & b)) / std::max(1, cv::countNonZero(a | b));
}

}  // namespace polhode::moving
