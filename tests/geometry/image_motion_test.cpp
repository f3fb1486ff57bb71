// Motion of image points, and pixels of a rolling shutter brought to one time.
#include "geometry/image_motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::image_motion_test {
namespace {

constexpr double kRange = 8.0;  // of the ball's centre, in its radii
const Eigen::Vector3d kRate_rad_s(0.1, -0.25, 0.15);
const Eigen::Vector3d kVelocity(0.02, 0.03, -0.01);  // radii a second

CameraModel camera() {
  return {.width_px = 640,
          .height_px = 480,
          .fu_px = 1500.0,
          .fv_px = 1490.0,
          .cu_px = 321.0,
          .cv_px = 236.0,
          .k1 = -0.1,
          .line_time_s = 1e-4};
}

/// A point of the ball, of radius 1, at a time.
Eigen::Vector3d point_C(const Eigen::Vector3d& p_T, double time_s) {
  return so3_exp(time_s * kRate_rad_s) * p_T + Eigen::Vector3d(0.2, -0.1, kRange) +
         time_s * kVelocity;
}

MovingPoint moving(const Eigen::Vector3d& p_T) {
  constexpr double kStep_s = 1e-4;
  const Eigen::Vector2d before = point_C(p_T, -kStep_s).hnormalized();
  const Eigen::Vector2d after = point_C(p_T, kStep_s).hnormalized();
  return {.normalised = point_C(p_T, 0.0).hnormalized(),
          .velocity_per_s = (after - before) / (2.0 * kStep_s)};
}

/// Points on the ball's near face, not at its rim.
std::vector<Eigen::Vector3d> near_face(int count, std::uint64_t seed) {
  Rng rng(seed, 0);
  std::vector<Eigen::Vector3d> points;
  while (static_cast<int>(points.size()) < count) {
    const Eigen::Vector3d p =
        Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
    if (p.z() < -0.3) {
      points.push_back(p);
    }
  }
  return points;
}

std::vector<MovingPoint> moving(const std::vector<Eigen::Vector3d>& points) {
  std::vector<MovingPoint> all;
  for (const Eigen::Vector3d& p : points) {
    all.push_back(moving(p));
  }
  return all;
}

double fastest(const std::vector<MovingPoint>& points) {
  double most = 0.0;
  for (const MovingPoint& point : points) {
    most = std::max(most, point.velocity_per_s.norm());
  }
  return most;
}

double worst_error(const ImageMotion& motion, const std::vector<MovingPoint>& points) {
  double worst = 0.0;
  for (const MovingPoint& point : points) {
    worst = std::max(worst, (velocity_at(motion, point.normalised) - point.velocity_per_s).norm());
  }
  return worst;
}

TEST(ImageMotion, OfATurningBallIsKnownToATenthWhereItIsNotItsRim) {
  const auto points = moving(near_face(200, 1));
  const auto others = moving(near_face(200, 2));
  EXPECT_LT(worst_error(fit_image_motion(points), others), 0.1 * fastest(points));
}

TEST(ImageMotion, IsNotDraggedByAFifthOfWrongPoints) {
  auto points = moving(near_face(200, 1));
  const ImageMotion clean = fit_image_motion(points);
  Rng rng(3, 0);
  for (std::size_t i = 0; i < points.size(); i += 5) {
    points[i].velocity_per_s += Eigen::Vector2d(0.1 + 0.1 * rng.normal(), 0.1 * rng.normal());
  }
  EXPECT_LT(
      worst_error(fit_image_motion(points), moving(near_face(200, 2))),
      worst_error(clean, moving(near_face(200, 2))) + 0.02 * fastest(moving(near_face(9, 1))));
}

TEST(ImageMotion, OfFewPointsIsTheirMean) {
  const Eigen::Vector2d velocity(0.3, -0.1);
  const std::vector<MovingPoint> points(3, {.normalised = {0.1, 0.2}, .velocity_per_s = velocity});
  EXPECT_LT((velocity_at(fit_image_motion(points), {0.5, 0.5}) - velocity).norm(), 1e-8);
}

TEST(ImageMotion, OfNoPointsIsNone) {
  EXPECT_EQ(velocity_at(fit_image_motion({}), {0.3, 0.1}), Eigen::Vector2d::Zero());
}

TEST(ImageMotion, OfPointsOnALineIsFinite) {
  std::vector<MovingPoint> points;
  for (int i = 0; i < 40; ++i) {
    points.push_back({.normalised = {0.001 * i, 0.001 * i}, .velocity_per_s = {0.1, 0.002 * i}});
  }
  EXPECT_LT(worst_error(fit_image_motion(points), points), 1e-6);
}

TEST(ImageMotion, GoesOnAsAtTheRimOfItsPoints) {
  const auto points = moving(near_face(200, 1));
  const ImageMotion motion = fit_image_motion(points);
  const Eigen::Vector2d rim = motion.centre + motion.reach;
  EXPECT_EQ(velocity_at(motion, rim), velocity_at(motion, rim + Eigen::Vector2d(3.0, 5.0)));
}

TEST(AtFrameTime, PutsAPointWhereItWasInTheMiddleRowsTime) {
  const CameraModel rolling = camera();
  const auto points = near_face(200, 1);
  const ImageMotion motion = fit_image_motion(moving(points));
  double before_px = 0.0;
  double after_px = 0.0;
  for (const Eigen::Vector3d& p : near_face(100, 2)) {
    Eigen::Vector2d pixel = project_px(rolling, point_C(p, 0.0));
    for (int i = 0; i < 5; ++i) {  // the row indicates when it is seen, and the other way round
      pixel = project_px(rolling, point_C(p, row_delay_s(rolling, pixel.y())));
    }
    const Eigen::Vector2d right = point_C(p, 0.0).hnormalized();
    const double focal_px = rolling.focal_px();
    before_px = std::max(before_px, focal_px * (undistort(rolling, pixel) - right).norm());
    after_px =
        std::max(after_px, focal_px * (at_frame_time(rolling, motion, pixel) - right).norm());
  }
  EXPECT_GT(before_px, 0.5);
  EXPECT_LT(after_px, 0.1 * before_px);
}

TEST(AtFrameTime, IsUndistortWhereAllRowsAreOfOneTime) {
  CameraModel global = camera();
  global.line_time_s = 0.0;
  const ImageMotion motion = fit_image_motion(moving(near_face(200, 1)));
  const Eigen::Vector2d pixel(100.3, 400.7);
  EXPECT_EQ(at_frame_time(global, motion, pixel), undistort(global, pixel));
}

}  // namespace
}  // namespace polhode::image_motion_test
