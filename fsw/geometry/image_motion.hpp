// How fast image points move, over the image. A rolling shutter reads each row at a time of its
// own; with this motion a point is brought to the time of the frame, that of the middle row.
#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/camera_model.hpp"

namespace polhode {

struct MovingPoint {
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();  ///< undistorted image point, plane z = 1
  Eigen::Vector2d velocity_per_s = Eigen::Vector2d::Zero();  ///< its velocity
};

/// A quadratic in the image point, as a body's surface bends the motion field more than its near
/// and far parts differ. Beyond the box of the fitted points it continues with the value at the
/// border.
struct ImageMotion {
  Eigen::Matrix<double, 2, 6> coefficients_per_s = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of the fitted points' box, normalised
  Eigen::Vector2d reach = Eigen::Vector2d::Ones();   ///< half the size of that box
};

/// Velocity of an image point [1/s, on the plane z = 1].
Eigen::Vector2d velocity_at(const ImageMotion& motion, const Eigen::Vector2d& normalised);

/// Robust fit (Cauchy weights at the median residual). Fewer than 12 points give a mean, fewer than
/// 24 a plane, else a quadratic; no points give zero.
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
