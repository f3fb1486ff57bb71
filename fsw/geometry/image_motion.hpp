// How fast image points move, over the image. A rolling shutter reads each row at a time of its
// own; with this motion a point is brought to the time of the frame, that of the middle row.
#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/camera_model.hpp"

namespace polhode {

struct MovingPoint {
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();  ///< undistorted image point, plane z = 1
  Eigen::Vector2d velocity_per_s = Eigen::Vector2d::Zero();  ///< of it
};

/// A quadratic of the image point: near and far parts of a body differ by less than its surface
/// bends the field. Beyond the points that it was fitted to it goes on as at their rim.
struct ImageMotion {
  Eigen::Matrix<double, 2, 6> coefficients_per_s = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of those points, normalised
  Eigen::Vector2d reach = Eigen::Vector2d::Ones();   ///< of theirs about it
};

/// Velocity of an image point [1/s, on the plane z = 1].
Eigen::Vector2d velocity_at(const ImageMotion& motion, const Eigen::Vector2d& normalised);

/// Robust fit (Cauchy weights at the median residual). A mean of fewer than 12 points, a plane of
/// fewer than 24, else a quadratic. No motion of no points.
/// @pre at most limits::kFeatures points
ImageMotion fit_image_motion(std::span<const MovingPoint> points);

/// Seconds by which a pixel's row is read after the middle row; negative before it.
double row_delay_s(const CameraModel& camera, double v_px);

/// Distorted pixel to the undistorted image point where it was at the frame's time. As undistort()
/// where all rows are of one time.
Eigen::Vector2d at_frame_time(const CameraModel& camera,
                              const ImageMotion& motion,
                              const Eigen::Vector2d& pixel);

}  // namespace polhode
