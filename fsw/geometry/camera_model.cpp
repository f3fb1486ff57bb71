#include "geometry/camera_model.hpp"

#include <Eigen/LU>
#include <cmath>

namespace polhode {
namespace {

Eigen::Vector2d distort(const CameraModel& camera, const Eigen::Vector2d& n) {
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (camera.k1 + r2 * camera.k2);
  return {x * radial + 2.0 * camera.p1 * x * y + camera.p2 * (r2 + 2.0 * x * x),
          y * radial + camera.p1 * (r2 + 2.0 * y * y) + 2.0 * camera.p2 * x * y};
}

Eigen::Matrix2d distort_jacobian(const CameraModel& camera, const Eigen::Vector2d& n) {
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (camera.k1 + r2 * camera.k2);
  const double slope = 2.0 * camera.k1 + 4.0 * camera.k2 * r2;  // d radial / d r2, times 2
  Eigen::Matrix2d J;
  J << radial + x * x * slope + 2.0 * camera.p1 * y + 6.0 * camera.p2 * x,
      x * y * slope + 2.0 * camera.p1 * x + 2.0 * camera.p2 * y,
      x * y * slope + 2.0 * camera.p1 * x + 2.0 * camera.p2 * y,
      radial + y * y * slope + 6.0 * camera.p1 * y + 2.0 * camera.p2 * x;
  return J;
}

}  // namespace

double CameraModel::focal_px() const { return std::sqrt(fu_px * fv_px); }

Eigen::Vector2d project_px(const CameraModel& camera, const Eigen::Vector2d& normalised) {
  const Eigen::Vector2d d = distort(camera, normalised);
  return {camera.fu_px * d.x() + camera.cu_px, camera.fv_px * d.y() + camera.cv_px};
}

Eigen::Vector2d project_px(const CameraModel& camera, const Eigen::Vector3d& p_C) {
  return project_px(camera, Eigen::Vector2d(p_C.x() / p_C.z(), p_C.y() / p_C.z()));
}

Eigen::Vector2d undistort(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cu_px) / camera.fu_px,
                               (pixel.y() - camera.cv_px) / camera.fv_px);
  // Each Newton step doubles the digits. 20 bounds the time beyond the fold, where none converges.
  constexpr int kIterations_max = 20;
  // An error of 1e-14 in normalised units is rounding.
  constexpr double kError2Min = 1e-28;
  Eigen::Vector2d n = target;
  for (int i = 0; i < kIterations_max; ++i) {
    const Eigen::Vector2d error = distort(camera, n) - target;
    if (error.squaredNorm() < kError2Min) {
      break;
    }
    n -= distort_jacobian(camera, n).inverse() * error;
  }
  return n;
}

}  // namespace polhode
