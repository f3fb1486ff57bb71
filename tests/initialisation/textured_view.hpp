// Views of a flat textured surface under an affine motion, with noise.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/core.hpp>

#include "base/rng.hpp"

namespace polhode::textured_view {

struct View {
  Eigen::Matrix2d affine = Eigen::Matrix2d::Identity();  ///< surface to image
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double gain = 1.0;
  double offset = 0.0;
  double noise = 1.0;  ///< gray levels

  [[nodiscard]] Eigen::Vector2d place(const Eigen::Vector2d& on_surface) const {
    return affine * on_surface + shift_px;
  }
};

/// Texture of many directions, 5 to 12 px long; edges of one direction where `edges`.
inline double level(const Eigen::Vector2d& p, bool edges) {
  if (edges) {
    return 110.0 + 60.0 * std::sin(0.7 * p.x());
  }
  return 110.0 + 25.0 * std::sin(0.9 * p.x() + 0.3 * p.y()) + 25.0 * std::sin(1.1 * p.y()) +
         20.0 * std::sin(0.6 * p.x() - 0.8 * p.y() + 1.0) + 15.0 * std::sin(0.53 * p.x() + 2.0);
}

/// 8-bit, 120 x 100 px.
inline cv::Mat render(const View& view, std::uint64_t seed, bool edges = false) {
  Rng rng(seed, 0);
  cv::Mat gray(100, 120, CV_8UC1);
  const Eigen::Matrix2d back = view.affine.inverse();
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u) {
      const Eigen::Vector2d on_surface = back * (Eigen::Vector2d(u, v) - view.shift_px);
      gray.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(
          view.gain * level(on_surface, edges) + view.offset + view.noise * rng.normal());
    }
  }
  return gray;
}

}  // namespace polhode::textured_view
