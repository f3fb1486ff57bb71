#include "solve/free_body_adjustment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::free_body_adjustment_test {
namespace {

constexpr double kSigma = 2e-4;

Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

/// Thirty points on a ball of radius 1 in twelve poses of a tumbling body; every point is seen in
/// every pose.
struct Scene {
  FreeBodyMotion motion;
  std::vector<PoseTime> times;
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> pose_fixed;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> point_fixed;
  std::vector<BundleObservation> observations;

  FreeBodyReport adjust(int iterations_max = 20) {
    const FreeBodyProblem problem{.bundle = {.poses = poses,
                                             .pose_fixed = pose_fixed,
                                             .points_T = points_T,
                                             .point_fixed = point_fixed,
                                             .observations = observations},
                                  .times = times,
                                  .motion = &motion,
                                  .shape_sigma = 1.5,
                                  .mass_centre_sigma = 1.0};
    return adjust_free_body(problem, {.iterations_max = iterations_max});
  }
};

Scene make_scene(double noise_sigmas, std::uint64_t seed) {
  Rng rng(seed, 23);
  Scene s;
  s.motion.reference.time_s = 8.0;
  s.motion.reference.R_IT = so3_exp({0.3, -0.2, 0.5});
  s.motion.reference.w_T_rad_s = {0.03, 0.09, 0.04};
  s.motion.shape = shape_of(Eigen::Vector3d(1.0, 1.6, 2.1).asDiagonal());
  s.motion.path << 0.2, -0.1, 10.0, 0.02, 0.01, -0.03, 0.05, -0.02, 0.03;
  for (int i = 0; i < 30; ++i) s.points_T.push_back(normal3(&rng).normalized());
  s.point_fixed.assign(s.points_T.size(), 0);
  for (int k = 0; k < 12; ++k) {
    // The observer rotates too, mostly about its line of sight.
    s.times.push_back({.time_s = 1.5 * k, .R_IC = so3_exp({0.0, 0.002 * k, 0.2 * k})});
    RotationState state = s.motion.reference;
    EXPECT_TRUE(advance(inertia_of(s.motion.shape), {}, 1.5 * k, state, nullptr));
    const Eigen::Vector3d centre_I =
        s.motion.path.head<3>() +
        (1.5 * k - s.motion.reference.time_s) * s.motion.path.segment<3>(3);
    const Eigen::Vector3d p_I = centre_I - state.R_IT * s.motion.path.tail<3>();
    const Eigen::Matrix3d R_CI = s.times.back().R_IC.transpose();
    s.poses.push_back(to_inverse_depth({.R_CT = R_CI * state.R_IT, .p_CT = R_CI * p_I}));
    for (int i = 0; i < 30; ++i) {
      BundleObservation o{.pose = k, .point = i, .sigma_normalised = kSigma};
      EXPECT_TRUE(
          reproject(s.poses.back(), s.points_T[static_cast<std::size_t>(i)], &o.normalised));
      o.normalised += noise_sigmas * kSigma * Eigen::Vector2d(rng.normal(), rng.normal());
      s.observations.push_back(o);
    }
  }
  s.pose_fixed.assign(s.poses.size(), 0);
  return s;
}

void disturb(FreeBodyMotion* motion) {
  motion->reference.R_IT = so3_exp({0.01, -0.02, 0.01}) * motion->reference.R_IT;
  motion->reference.w_T_rad_s *= 1.03;
  motion->shape += InertiaShape::Constant(0.05);
  motion->path.head<2>() += Eigen::Vector2d(0.02, -0.01);
}

TEST(FreeBodyAdjustment, BringsADisturbedMotionBackToItsImages) {
  Scene s = make_scene(0.0, 1);
  const FreeBodyMotion truth = s.motion;
  disturb(&s.motion);
  const FreeBodyReport report = s.adjust(50);
  ASSERT_TRUE(report.bundle.usable);
  EXPECT_GT(report.bundle.cost_before, 100.0);
  // What the two priors cost remains: half the squares of shape and offset over their sigmas.
  EXPECT_LT(report.bundle.cost_after, 0.5);
  // T's axes may have turned as a whole: the rate is compared by its length.
  EXPECT_NEAR(s.motion.reference.w_T_rad_s.norm(), truth.reference.w_T_rad_s.norm(), 1e-4);
}

TEST(FreeBodyAdjustment, MakesPosesThoseOfTheMotion) {
  Scene s = make_scene(1.0, 2);
  // What the poses were before does not count.
  for (InverseDepthPose& pose : s.poses) pose.R_CT = so3_exp({0.1, 0.1, 0.1}) * pose.R_CT;
  ASSERT_TRUE(s.adjust().bundle.usable);
  for (std::size_t k = 0; k < s.poses.size(); ++k) {
    RotationState state = s.motion.reference;
    ASSERT_TRUE(advance(inertia_of(s.motion.shape), {}, s.times[k].time_s, state, nullptr));
    EXPECT_LT(rotation_angle_rad(s.times[k].R_IC * s.poses[k].R_CT, state.R_IT), 1e-5) << k;
  }
}

TEST(FreeBodyAdjustment, GoesBelowTheTruthsCostByWhatTheNoiseAllows) {
  Scene s = make_scene(1.0, 3);
  const FreeBodyReport report = s.adjust(50);
  ASSERT_TRUE(report.bundle.usable);
  EXPECT_LT(report.bundle.cost_after, report.bundle.cost_before);
  // 110 unknowns less the gauge's 7: their chi-square is 103 with a scatter of 14, half of it
  // cost; the loss weighs normal residuals down by up to a third.
  EXPECT_GT(report.bundle.cost_before - report.bundle.cost_after, 20.0);
  EXPECT_LT(report.bundle.cost_before - report.bundle.cost_after, 80.0);
}

TEST(FreeBodyAdjustment, InformationIsSymmetricAndPositive) {
  Scene s = make_scene(1.0, 4);
  const FreeBodyReport report = s.adjust();
  ASSERT_TRUE(report.bundle.usable);
  const FreeBodyInformation& H = report.information;
  EXPECT_LT((H - H.transpose()).norm(), 1e-9 * H.norm());
  const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd balanced = scale.asDiagonal() * H * scale.asDiagonal();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(balanced).eigenvalues()(0), 0.0);
}

TEST(FreeBodyAdjustment, DoesNotDependOnTheOrderOfThePoses) {
  Scene s = make_scene(1.0, 5);
  const Scene in_order = make_scene(1.0, 5);
  Scene shuffled = make_scene(1.0, 5);
  const auto place = [](std::int32_t k) { return 5 * k % 12; };
  for (std::int32_t k = 0; k < 12; ++k) {
    const auto from = static_cast<std::size_t>(k);
    const auto to = static_cast<std::size_t>(place(k));
    shuffled.times[to] = in_order.times[from];
    shuffled.poses[to] = in_order.poses[from];
  }
  for (BundleObservation& o : shuffled.observations) o.pose = place(o.pose);
  const FreeBodyReport one = s.adjust();
  const FreeBodyReport other = shuffled.adjust();
  ASSERT_TRUE(one.bundle.usable && other.bundle.usable);
  EXPECT_NEAR(one.bundle.cost_after, other.bundle.cost_after, 1e-3);
  EXPECT_LT((s.motion.reference.w_T_rad_s - shuffled.motion.reference.w_T_rad_s).norm(), 1e-6);
}

TEST(FreeBodyAdjustment, HasNoAnswerWithoutImagesBehindTheCameraOrOfARunaway) {
  Scene none = make_scene(0.0, 6);
  none.observations.clear();
  EXPECT_FALSE(none.adjust().bundle.usable);
  Scene behind = make_scene(0.0, 6);
  behind.motion.path(2) = -10.0;
  EXPECT_FALSE(behind.adjust().bundle.usable);
  Scene runaway = make_scene(0.0, 6);
  runaway.motion.reference.w_T_rad_s = {0.0, 0.0, 1e9};
  const FreeBodyReport report = runaway.adjust();
  EXPECT_FALSE(report.bundle.usable);
  EXPECT_TRUE(report.information.isZero());
}

}  // namespace
}  // namespace polhode::free_body_adjustment_test
