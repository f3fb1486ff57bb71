// Pinhole camera with radial-tangential distortion, as OpenCV and the ASL layout define it.
#pragma once

#include <Eigen/Core>

namespace polhode {

struct CameraModel {
  int width_px = 0;
  int height_px = 0;
  double fu_px = 0.0;
  double fv_px = 0.0;
  double cu_px = 0.0;  ///< the top-left pixel's centre is (0, 0)
  double cv_px = 0.0;
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double line_time_s = 0.0;  ///< from one row to the next below it; 0: all rows are of one time

  /// Geometric mean of the focal lengths: pixels a radian near the axis.
  [[nodiscard]] double focal_px() const;
};

/// Normalised image point (x/z, y/z) to distorted pixel.
Eigen::Vector2d project_px(const CameraModel& camera, const Eigen::Vector2d& normalised);

/// Point in C (z > 0) to distorted pixel.
Eigen::Vector2d project_px(const CameraModel& camera, const Eigen::Vector3d& p_C);

/// Distorted pixel to normalised undistorted image point, by at most 20 Newton steps on the
/// distortion polynomial. Exact to 1e-12 where the model is one-to-one. Beyond its fold the last
/// iterate is returned.
Eigen::Vector2d undistort(const CameraModel& camera, const Eigen::Vector2d& pixel);

}  // namespace polhode
