#include "solve/rigid_body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "solve/mass_centre_fit.hpp"

namespace polhode::rigid_body_test {
namespace {

InertiaShape random_shape(Rng& rng, double size) {
  InertiaShape shape;
  for (int k = 0; k < 5; ++k) shape(k) = size * rng.normal();
  return shape;
}

RotationState random_state(Rng& rng, double rate_rad_s) {
  RotationState state;
  state.R_IT = so3_exp({rng.normal(), rng.normal(), rng.normal()});
  state.w_T_rad_s = rate_rad_s * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
  return state;
}

Orbit some_orbit() { return {.mean_motion_rad_s = 0.0011, .R_IH = so3_exp({0.3, -0.2, 0.9})}; }

TEST(Inertia, OfEveryShapeIsPhysical) {
  Rng rng(1, 0);
  for (int i = 0; i < 200; ++i) {
    const Inertia inertia = inertia_of(random_shape(rng, 1.5));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inertia.J_T);
    const Eigen::Vector3d J = eigen.eigenvalues();
    EXPECT_GT(J(0), 0.0);
    EXPECT_GE(J(0) + J(1), J(2) * (1.0 - 1e-12));  // the triangle inequality
    EXPECT_NEAR(J(2), 1.0, 1e-12);
    EXPECT_LT((inertia.J_T * inertia.J_inverse - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  }
}

TEST(Inertia, HasTheDerivativesOfItsDifferencesUpToItsScale) {
  Rng rng(2, 0);
  for (int i = 0; i < 50; ++i) {
    const InertiaShape shape = i == 0 ? InertiaShape::Zero() : random_shape(rng, 0.7);
    const Inertia inertia = inertia_of(shape);
    for (int k = 0; k < 5; ++k) {
      constexpr double kStep = 1e-5;
      InertiaShape plus = shape;
      InertiaShape minus = shape;
      plus(k) += kStep;
      minus(k) -= kStep;
      // The scale is held in the derivative and not in the tensor: compare J / tr J.
      const Eigen::Matrix3d J_plus = inertia_of(plus).J_T;
      const Eigen::Matrix3d J_minus = inertia_of(minus).J_T;
      const Eigen::Matrix3d numeric =
          (J_plus / J_plus.trace() - J_minus / J_minus.trace()) / (2.0 * kStep);
      const Eigen::Matrix3d& d = inertia.J_by_shape[static_cast<std::size_t>(k)];
      const double trace = inertia.J_T.trace();
      const Eigen::Matrix3d analytic = d / trace - inertia.J_T * d.trace() / (trace * trace);
      EXPECT_LT((numeric - analytic).norm(), 1e-8);
    }
  }
}

TEST(Inertia, ShapeOfATensorGivesItBack) {
  Rng rng(3, 0);
  for (int i = 0; i < 50; ++i) {
    const InertiaShape shape = random_shape(rng, 0.6);
    EXPECT_LT((shape_of(7.0 * inertia_of(shape).J_T) - shape).norm(), 1e-9);
  }
  EXPECT_TRUE(shape_of(Eigen::Vector3d(1.0, 0.1, 0.1).asDiagonal()).allFinite());  // no such body
}

TEST(Turning, KeepsMomentumAndEnergy) {
  Rng rng(4, 0);
  for (int i = 0; i < 20; ++i) {
    const Inertia inertia = inertia_of(random_shape(rng, 0.8));
    RotationState state = random_state(rng, 0.1);
    const Eigen::Vector3d momentum = state.R_IT * inertia.J_T * state.w_T_rad_s;
    const double energy = state.w_T_rad_s.dot(inertia.J_T * state.w_T_rad_s);
    ASSERT_TRUE(advance(inertia, {}, 200.0, state, nullptr));
    // Up to 60 rad in 600 steps, 1e-8 rad each.
    EXPECT_LT((state.R_IT * inertia.J_T * state.w_T_rad_s - momentum).norm(),
              1e-5 * momentum.norm());
    EXPECT_NEAR(state.w_T_rad_s.dot(inertia.J_T * state.w_T_rad_s), energy, 1e-5 * energy);
    EXPECT_EQ(state.time_s, 200.0);
  }
}

TEST(Turning, RunsBackToWhereItCameFrom) {
  Rng rng(5, 0);
  for (const Orbit& orbit : {Orbit{}, some_orbit()}) {
    const Inertia inertia = inertia_of(random_shape(rng, 0.8));
    const RotationState start = random_state(rng, 0.05);
    RotationState state = start;
    ASSERT_TRUE(advance(inertia, orbit, 300.0, state, nullptr));
    ASSERT_TRUE(advance(inertia, orbit, 0.0, state, nullptr));
    EXPECT_LT(rotation_angle_rad(state.R_IT, start.R_IT), 2e-6);
    EXPECT_LT((state.w_T_rad_s - start.w_T_rad_s).norm(), 2e-7);
  }
}

TEST(Turning, OfABodyOfRevolutionIsThatOfTheTextbook) {
  // Moments 0.47, 0.47, 0.02: w_T turns about z at (J_z / J_x - 1) w_z.
  const Inertia inertia = inertia_of(shape_of(Eigen::Vector3d(0.47, 0.47, 0.02).asDiagonal()));
  RotationState state;
  state.w_T_rad_s = {0.0, 0.002, 0.017};
  ASSERT_TRUE(advance(inertia, {}, 1000.0, state, nullptr));
  const double turn = (0.02 / 0.47 - 1.0) * 0.017 * 1000.0;
  EXPECT_NEAR(state.w_T_rad_s.x(), -0.002 * std::sin(turn), 1e-7);
  EXPECT_NEAR(state.w_T_rad_s.y(), 0.002 * std::cos(turn), 1e-7);
  EXPECT_NEAR(state.w_T_rad_s.z(), 0.017, 1e-12);
}

TEST(Turning, HasTheDerivativesOfItsDifferences) {
  Rng rng(6, 0);
  for (const Orbit& orbit : {Orbit{}, some_orbit()}) {
    const InertiaShape shape = random_shape(rng, 0.6);
    const RotationState start = random_state(rng, 0.03);
    RotationState end = start;
    RotationDerivative derivative = RotationDerivative::at_reference();
    ASSERT_TRUE(advance(inertia_of(shape), orbit, 400.0, end, &derivative));
    for (int k = 0; k < kRotationUnknowns; ++k) {
      std::array<RotationState, 2> ends;
      const double step = k >= 3 && k < 6 ? 1e-7 : 1e-5;
      for (int side = 0; side < 2; ++side) {
        RotationState from = start;
        InertiaShape at = shape;
        Eigen::Vector3d e = Eigen::Vector3d::Zero();
        e(k % 3) = side == 0 ? step : -step;
        if (k < 3) from.R_IT = so3_exp(e) * from.R_IT;
        if (k >= 3 && k < 6) from.w_T_rad_s += e;
        if (k >= 6) at(k - 6) += side == 0 ? step : -step;
        ASSERT_TRUE(advance(inertia_of(at), orbit, 400.0, from, nullptr));
        ends[static_cast<std::size_t>(side)] = from;
      }
      const Eigen::Vector3d attitude =
          so3_log(ends[0].R_IT * ends[1].R_IT.transpose()) / (2.0 * step);
      const Eigen::Vector3d rate = (ends[0].w_T_rad_s - ends[1].w_T_rad_s) / (2.0 * step);
      // Derivatives steer a search and make covariances: a thousandth is plenty.
      EXPECT_LT((attitude - derivative.attitude_I.col(k)).norm(), 1e-3 * (1.0 + attitude.norm()))
          << k;
      EXPECT_LT((rate - derivative.rate_T.col(k)).norm(), 1e-3 * (0.03 + rate.norm())) << k;
    }
  }
}

TEST(Turning, ThatIsNotANumberOrTooFarIsRefused) {
  RotationState fast;
  fast.w_T_rad_s = {0.0, 0.0, 1e9};
  EXPECT_FALSE(advance(inertia_of(InertiaShape::Zero()), {}, 1.0, fast, nullptr));
  RotationState bad;
  bad.w_T_rad_s.setConstant(std::nan(""));
  EXPECT_FALSE(advance(inertia_of(InertiaShape::Zero()), {}, 1.0, bad, nullptr));
}

TEST(Path, OfHillsEquationsFulfilsThem) {
  const Orbit orbit = some_orbit();
  const double n = orbit.mean_motion_rad_s;
  Eigen::Matrix<double, 6, 1> start;
  start << 10.0, -3.0, 5.0, 0.01, 0.004, -0.02;
  // In inertial axes the relative acceleration is -n^2 (p - 3 r (r p)), r being radial.
  constexpr double kStep_s = 0.5;
  for (const double t : {0.0, 100.0, 1500.0}) {
    const auto at = [&](double time) {
      return Eigen::Matrix<double, 6, 1>(translation_transition(orbit, 0.0, time) * start);
    };
    const Eigen::Vector3d acceleration =
        (at(t + kStep_s).tail<3>() - at(t - kStep_s).tail<3>()) / (2.0 * kStep_s);
    const Eigen::Vector3d velocity =
        (at(t + kStep_s).head<3>() - at(t - kStep_s).head<3>()) / (2.0 * kStep_s);
    const Eigen::Vector3d p = at(t).head<3>();
    const Eigen::Vector3d r = orbit.R_IH_at(t).col(0);
    EXPECT_LT((acceleration + n * n * (p - 3.0 * r * r.dot(p))).norm(), 1e-9);
    EXPECT_LT((velocity - at(t).tail<3>()).norm(), 1e-7);
  }
  // From rest at 10 m radial, seen in Hill's turning frame: 6.8 m in 600 s (6.5 cm in 60 s).
  const Eigen::Matrix3d R_IH = orbit.R_IH;
  Eigen::Matrix<double, 6, 1> rest;
  rest << R_IH * Eigen::Vector3d(10.0, 0.0, 0.0), R_IH * Eigen::Vector3d(0.0, 10.0 * n, 0.0);
  const Eigen::Vector3d later = orbit.R_IH_at(600.0).transpose() *
                                (translation_transition(orbit, 0.0, 600.0) * rest).head<3>();
  EXPECT_NEAR((later - Eigen::Vector3d(10.0, 0.0, 0.0)).norm(), 6.8, 0.2);
}

}  // namespace
}  // namespace polhode::rigid_body_test
