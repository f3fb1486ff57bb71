#include "geometry/so3.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/rng.hpp"
#include "numeric_jacobian.hpp"

namespace polhode::so3_test {
namespace {

Eigen::Vector3d direction(Rng& rng) {
  return Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
}

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-14 * 10 &&
         R.determinant() > 0.0;
}

TEST(So3, HatIsTheCrossProduct) {
  Rng rng(1, 0);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d a = direction(rng);
    const Eigen::Vector3d b = direction(rng);
    EXPECT_LT((hat(a) * b - a.cross(b)).norm(), 1e-15);
  }
}

TEST(So3, ExpIsARotationByTheNormAboutTheDirection) {
  Rng rng(2, 0);
  for (const double angle :
       {0.0, 1e-12, 1e-8, 0.9e-4, 1.1e-4, 1e-3, 0.5, 2.0, 3.14159, 4.0, 20.0}) {
    const Eigen::Vector3d axis = direction(rng);
    const Eigen::Matrix3d R = so3_exp(angle * axis);
    EXPECT_TRUE(is_rotation(R)) << angle;
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((R - expected).norm(), 1e-14) << angle;
  }
}

TEST(So3, LogUndoesExpBelowPi) {
  Rng rng(3, 0);
  for (int i = 0; i < 2000; ++i) {
    // From 1e-10 to almost pi, as many in each decade.
    const double angle = std::min(3.1415, std::pow(10.0, -10.0 + 10.5 * rng.uniform()));
    const Eigen::Vector3d phi = angle * direction(rng);
    EXPECT_LT((so3_log(so3_exp(phi)) - phi).norm(), 1e-14 + 1e-12 * angle) << angle;
  }
  EXPECT_EQ(so3_log(Eigen::Matrix3d::Identity()).norm(), 0.0);
}

TEST(So3, LogAtPiHasTheAxisWithEitherSign) {
  Rng rng(4, 0);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d axis = direction(rng);
    const Eigen::Vector3d phi = so3_log(so3_exp(std::numbers::pi * axis));
    EXPECT_NEAR(phi.norm(), std::numbers::pi, 1e-7);
    EXPECT_NEAR(std::abs(phi.normalized().dot(axis)), 1.0, 1e-12);
  }
}

TEST(So3, LeftJacobianIsTheDerivativeOfExp) {
  Rng rng(5, 0);
  for (const double angle : {0.0, 1e-6, 0.99e-4, 1.01e-4, 0.01, 0.7, 2.5, 3.1}) {
    const Eigen::Vector3d phi = angle * direction(rng);
    const Eigen::Matrix3d numeric =
        numeric_jacobian<3, 3>([&](const Eigen::Vector3d& d) -> Eigen::Vector3d {
          return so3_log(so3_exp(phi + d) * so3_exp(phi).transpose());
        });
    EXPECT_LT((so3_left_jacobian(phi) - numeric).norm(), 1e-8) << angle;
  }
}

TEST(So3, NearestRotationIsTheRotationItselfAndUndoesSmallDamage) {
  Rng rng(6, 0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix3d R = so3_exp(2.0 * direction(rng));
    EXPECT_LT((nearest_rotation(R) - R).norm(), 1e-14);
    EXPECT_LT((nearest_rotation(2.5 * R) - R).norm(), 1e-14);
    Eigen::Matrix3d damaged = R;
    for (Eigen::Index k = 0; k < 9; ++k) damaged(k) += 1e-3 * rng.normal();
    const Eigen::Matrix3d repaired = nearest_rotation(damaged);
    EXPECT_TRUE(is_rotation(repaired));
    EXPECT_LE((repaired - damaged).norm(), (R - damaged).norm());
  }
  EXPECT_TRUE(is_rotation(nearest_rotation(-Eigen::Matrix3d::Identity())));
}

TEST(So3, AngleIsThatOfTheRotationBetween) {
  Rng rng(7, 0);
  for (const double angle : {0.0, 1e-9, 0.3, 3.0}) {
    const Eigen::Matrix3d R = so3_exp(direction(rng));
    EXPECT_NEAR(rotation_angle_rad(R, R * so3_exp(angle * direction(rng))), angle, 1e-13);
  }
}

}  // namespace
}  // namespace polhode::so3_test
