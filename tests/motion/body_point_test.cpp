// A point of a body whose motion is known, against the closed form and against drawn errors.
#include "motion/body_point.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "base/rng.hpp"
#include "free_body.hpp"
#include "geometry/so3.hpp"

namespace polhode::body_point_test {
namespace {

constexpr std::int64_t kReference_ns = 1'700'000'000'000'000'000;
const Eigen::Vector3d kPoint_T(0.4, -0.3, 0.8);

std::int64_t after(double seconds) { return kReference_ns + std::llround(1e9 * seconds); }

/// Tumbles: no component of the rate is constant.
MotionEstimate tumbling(double sigma) {
  MotionEstimate motion;
  RigidModel& model = motion.model;
  model.status = ModelStatus::kAccepted;
  model.translation_known = true;
  model.reference_ns = kReference_ns;
  model.reference.R_IT = so3_exp({0.3, -0.2, 0.5});
  model.reference.w_T_rad_s = {0.02, 0.04, -0.03};
  model.shape = shape_of(Eigen::Vector3d(1.0, 1.4, 1.9).asDiagonal());
  model.path << 0.3, -0.2, 12.0, 0.01, -0.02, 0.03, 0.05, -0.02, 0.04;
  model.covariance = sigma * sigma * ModelCovariance::Identity();
  return motion;
}

Result<PredictedPoint> point_after(double seconds,
                                   const MotionEstimate& motion,
                                   const Eigen::Vector3d& p_T) {
  return predict_point(p_T, after(seconds), {}, {}, motion);
}

TEST(BodyPoint, MovesWithTheBody) {
  const MotionEstimate motion = tumbling(1e-3);
  for (const double seconds : {0.0, 3.0, 60.0, 300.0}) {
    const auto point = point_after(seconds, motion, kPoint_T);
    const auto body = predict_motion(motion.model, after(seconds));
    ASSERT_TRUE(point.ok() && body.ok()) << seconds;
    const Pose& pose = body.value().pose;
    EXPECT_LT((point.value().p_I - pose.to_camera(kPoint_T)).norm(), 1e-9) << seconds;
    const Eigen::Vector3d v = body.value().v_I + pose.R_CT * body.value().w_T_rad_s.cross(kPoint_T);
    EXPECT_LT((point.value().v_I - v).norm(), 1e-9) << seconds;
    EXPECT_TRUE(point.value().by_dynamics);
    // The body's pose has the error of the point, too, by way of the arm.
    PoseCovariance by = PoseCovariance::Identity();
    by.bottomLeftCorner<3, 3>() = -hat(pose.R_CT * kPoint_T);
    const PoseCovariance expected = by * body.value().covariance * by.transpose();
    EXPECT_LT((point.value().covariance - expected).norm(), 1e-9 * expected.norm()) << seconds;
  }
}

/// One way in which the model may be wrong, drawn from its covariance.
RigidModel drawn(const RigidModel& model, double sigma, Rng* rng) {
  RigidModel out = model;
  const auto some = [&]() -> Eigen::Vector3d {
    const double x = rng->normal();
    const double y = rng->normal();
    return sigma * Eigen::Vector3d(x, y, rng->normal());
  };
  out.reference.R_IT = so3_exp(some()) * model.reference.R_IT;
  out.reference.w_T_rad_s += some();
  out.path.head<3>() += some();
  out.path.segment<3>(3) += some();
  out.path.tail<3>() += some();
  return out;
}

// verifies: MOT-14
TEST(BodyPoint, HasTheErrorsThatDrawnModelsHave) {
  constexpr double kSigma = 1e-4;
  constexpr int kDraws = 2000;
  MotionEstimate motion = tumbling(kSigma);
  // The moments are taken as known: what a draw of them does is the integration's own test.
  motion.model.covariance.middleRows<kRotationUnknowns - 6>(6).setZero();
  motion.model.covariance.middleCols<kRotationUnknowns - 6>(6).setZero();
  const auto told = point_after(40.0, motion, kPoint_T);
  ASSERT_TRUE(told.ok());
  Rng rng(7, 0);
  double nees_p = 0.0;
  double nees_v = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const auto one = predict_motion(drawn(motion.model, kSigma, &rng), after(40.0));
    ASSERT_TRUE(one.ok());
    const Pose& pose = one.value().pose;
    const Eigen::Vector3d p = pose.to_camera(kPoint_T) - told.value().p_I;
    const Eigen::Vector3d v =
        one.value().v_I + pose.R_CT * one.value().w_T_rad_s.cross(kPoint_T) - told.value().v_I;
    nees_p += p.dot(told.value().covariance.bottomRightCorner<3, 3>().ldlt().solve(p)) / 3.0;
    nees_v += v.dot(told.value().covariance_v_I.ldlt().solve(v)) / 3.0;
  }
  // A mean of 3 * 2000 squares has a sigma of sqrt(2 / 6000) = 0.018: four of them.
  EXPECT_NEAR(nees_p / kDraws, 1.0, 0.073);
  EXPECT_NEAR(nees_v / kDraws, 1.0, 0.073);
}

TEST(BodyPoint, HasTheErrorOfAReanchoredMap) {
  const MotionEstimate motion = tumbling(1e-6);
  MapDrift drift;
  drift.reanchoring(2, 2) = 0.01 * 0.01;
  const auto point = predict_point(kPoint_T, after(0.0), drift, {}, motion);
  ASSERT_TRUE(point.ok());
  // A turn about z of I moves the point by its arm across z.
  const Eigen::Vector3d arm = motion.model.reference.R_IT * kPoint_T;
  const double across = arm.head<2>().norm();
  EXPECT_NEAR(
      std::sqrt(point.value().covariance.bottomRightCorner<3, 3>().trace()), 0.01 * across, 1e-4);
}

TEST(BodyPoint, OfAModelThatDoesNotReachIsToldByNothing) {
  MotionEstimate motion = tumbling(1e-3);
  const double rate = motion.model.reference.w_T_rad_s.norm();
  const double reach_s = kPointStepsMax * kRotationStepAngle_rad / rate;
  EXPECT_TRUE(point_after(0.99 * reach_s, motion, kPoint_T).ok());
  EXPECT_EQ(point_after(1.01 * reach_s, motion, kPoint_T).error().code, ErrorCode::kDegenerate);
  motion.departures = 1;  // and there are no poses to go by
  EXPECT_EQ(point_after(1.0, motion, kPoint_T).error().code, ErrorCode::kDegenerate);
}

TEST(BodyPoint, ByTheLastPosesFollowsThemForTenSeconds) {
  FreeBody body;
  body.w_T_rad_s = {0.0, 0.0, 0.05};
  MotionEstimate motion;
  for (const PoseSample& sample : observed(tumble(body, 12, 1.0), {}, 5)) {
    EXPECT_TRUE(motion.recent.push_back(sample));
  }
  const std::int64_t last_ns = motion.recent.back().timestamp_ns;
  const auto ask = [&](double seconds) {
    return predict_point(kPoint_T, last_ns + std::llround(1e9 * seconds), {}, {}, motion);
  };
  const auto now = ask(0.0);
  const auto soon = ask(9.9);
  ASSERT_TRUE(now.ok() && soon.ok());
  EXPECT_FALSE(soon.value().by_dynamics);
  EXPECT_TRUE(soon.value().v_I.isZero());
  const Eigen::Vector3d off = now.value().p_I - motion.recent.back().pose.to_camera(kPoint_T);
  const Eigen::Matrix3d covariance = now.value().covariance.bottomRightCorner<3, 3>();
  EXPECT_LT(off.dot(covariance.ldlt().solve(off)),
            2.0 * 16.3);  // both have errors; chi2(3), 99.9 %
  const Eigen::Matrix3d later = soon.value().covariance.bottomRightCorner<3, 3>();
  EXPECT_GT(later.trace(), covariance.trace());
  EXPECT_FALSE(ask(10.1).ok());
}

}  // namespace
}  // namespace polhode::body_point_test
