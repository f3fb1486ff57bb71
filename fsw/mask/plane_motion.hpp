// The motion of a plane between two images: a homography through points, most of which may be
// outliers.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace polhode {

/// Consensus of four-point samples: at most 100 from a fixed stream of random numbers. Then least
/// squares on the points that agree. No heap beyond `agrees`.
/// @param fit_px a point agrees within this distance.
/// @param agrees per point, 1 where it agrees.
/// @return false when fewer than 8 points agree.
bool fit_plane_motion(std::span<const cv::Point2f> from,
                      std::span<const cv::Point2f> to,
                      double fit_px,
                      cv::Matx33d* motion,
                      std::vector<std::uint8_t>* agrees);

/// Position of a point after the motion.
cv::Point2f moved(const cv::Matx33d& motion, const cv::Point2f& point);

}  // namespace polhode
