// A model made by hand, a body that spins about one principal axis, against the closed form.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

#include "geometry/so3.hpp"
#include "motion/rigid_model.hpp"

namespace polhode::model_prediction_test {
namespace {

constexpr std::int64_t kReference_ns = 1'700'000'000'000'000'000;
constexpr double kRate_rad_s = 0.05;
const Eigen::Vector3d kCentre(0.3, -0.2, 12.0);
const Eigen::Vector3d kVelocity(0.01, -0.02, 0.03);
const Eigen::Vector3d kOffset_T(0.05, -0.02, 0.04);

std::int64_t after(double seconds) { return kReference_ns + std::llround(1e9 * seconds); }

RigidModel spinning(double sigma) {
  RigidModel model;
  model.status = ModelStatus::kAccepted;
  model.translation_known = true;
  model.reference_ns = kReference_ns;
  model.reference.w_T_rad_s = {0.0, 0.0, kRate_rad_s};
  model.shape = shape_of(Eigen::Vector3d(1.0, 1.5, 2.0).asDiagonal());
  model.path << kCentre, kVelocity, kOffset_T;
  model.covariance = sigma * sigma * ModelCovariance::Identity();
  return model;
}

Eigen::Matrix3d attitude(double t) { return so3_exp({0.0, 0.0, kRate_rad_s * t}); }

Pose pose_of(double t) {
  return {.R_CT = attitude(t), .p_CT = kCentre + t * kVelocity - attitude(t) * kOffset_T};
}

PoseSample sample_at(double t, double sigma) {
  return {.timestamp_ns = after(t),
          .pose = pose_of(t),
          .covariance = sigma * sigma * PoseCovariance::Identity()};
}

TEST(ModelPrediction, FollowsTheSpinAndTheStraightLine_LaterAndEarlier) {
  const RigidModel model = spinning(1e-3);
  for (const double t : {-100.0, 0.0, 7.0, 250.0}) {
    const auto at = predict_motion(model, after(t));
    ASSERT_TRUE(at.ok()) << t;
    EXPECT_EQ(at.value().timestamp_ns, after(t));
    EXPECT_LT(rotation_angle_rad(at.value().pose.R_CT, pose_of(t).R_CT), 1e-6) << t;
    EXPECT_LT((at.value().pose.p_CT - pose_of(t).p_CT).norm(), 1e-6) << t;
    const Eigen::Vector3d w(0.0, 0.0, kRate_rad_s);
    EXPECT_LT((at.value().w_T_rad_s - w).norm(), 1e-9) << t;
    EXPECT_LT((at.value().v_I - (kVelocity - attitude(t) * w.cross(kOffset_T))).norm(), 1e-6) << t;
    EXPECT_TRUE(at.value().translation_known);
  }
}

TEST(ModelPrediction, SigmaGrowsWithTheUncertaintyOfTheRate) {
  RigidModel model = spinning(0.0);
  model.covariance(5, 5) = 1e-8;  // the rate about the spin axis: 1e-4 rad/s
  const auto at = predict_motion(model, after(100.0));
  ASSERT_TRUE(at.ok());
  EXPECT_NEAR(std::sqrt(at.value().covariance(2, 2)), 1e-2, 1e-5);
  EXPECT_LT(std::sqrt(at.value().covariance(0, 0)), 1e-5);
}

TEST(ModelPrediction, WithoutAPathTellsOnlyTheRotation) {
  RigidModel model = spinning(1e-3);
  model.translation_known = false;
  const auto at = predict_motion(model, after(10.0));
  ASSERT_TRUE(at.ok());
  EXPECT_FALSE(at.value().translation_known);
  EXPECT_TRUE(at.value().pose.p_CT.isZero());
  EXPECT_LT(rotation_angle_rad(at.value().pose.R_CT, attitude(10.0)), 1e-9);
}

TEST(ModelPrediction, IsRefusedByAModelThatIsNotAcceptedOrDoesNotReach) {
  RigidModel model = spinning(1e-3);
  // kRotationStepsMax steps of kRotationStepAngle_rad: 20,000 s at this rate.
  const double reach_s = kRotationStepsMax * kRotationStepAngle_rad / kRate_rad_s;
  EXPECT_EQ(predict_motion(model, after(2.0 * reach_s)).error().code, ErrorCode::kDegenerate);
  RigidModel moved = model;
  EXPECT_FALSE(move_reference(after(2.0 * reach_s), moved));
  EXPECT_EQ(moved.reference_ns, kReference_ns);
  model.status = ModelStatus::kResidualsTooLarge;
  EXPECT_EQ(predict_motion(model, after(1.0)).error().code, ErrorCode::kDegenerate);
  EXPECT_FALSE(move_reference(after(1.0), model));
  EXPECT_FALSE(predict_from(model, sample_at(0.0, 1e-3), after(1.0)).ok());
  EXPECT_FALSE(chi2_against(model, sample_at(0.0, 1e-3), PoseCovariance::Zero()).ok());
}

TEST(ModelPrediction, IsTheSameFromAMovedReference) {
  const RigidModel model = spinning(1e-4);
  RigidModel moved = model;
  ASSERT_TRUE(move_reference(after(-40.0), moved));
  EXPECT_EQ(moved.reference_ns, after(-40.0));
  EXPECT_EQ(moved.reference.time_s, 0.0);
  const auto one = predict_motion(model, after(60.0));
  const auto other = predict_motion(moved, after(60.0));
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_LT(rotation_angle_rad(one.value().pose.R_CT, other.value().pose.R_CT), 1e-7);
  EXPECT_LT((one.value().pose.p_CT - other.value().pose.p_CT).norm(), 1e-7);
  EXPECT_LT((one.value().covariance - other.value().covariance).norm(),
            1e-3 * one.value().covariance.norm());
}

TEST(ModelPrediction, AtAStateIsThatAtItsTime) {
  const RigidModel model = spinning(1e-3);
  RotationState state = model.reference;
  RotationDerivative derivative = RotationDerivative::at_reference();
  const double ahead_s = seconds_between(kReference_ns, after(30.0));
  ASSERT_TRUE(advance(inertia_of(model.shape), model.orbit, ahead_s, state, &derivative));
  const MotionPrediction in_parts = predict_at(model, state, derivative);
  const auto at_once = predict_motion(model, after(30.0));
  ASSERT_TRUE(at_once.ok());
  EXPECT_EQ(in_parts.timestamp_ns, after(30.0));
  EXPECT_EQ(in_parts.pose.R_CT, at_once.value().pose.R_CT);
  EXPECT_EQ(in_parts.covariance, at_once.value().covariance);
}

TEST(PredictFrom, CarriesTheLastPosesErrorAlong) {
  // The map has drifted: the last pose is turned and shifted against the model.
  PoseSample last = sample_at(20.0, 1e-3);
  const Eigen::Matrix3d off = so3_exp({0.02, -0.01, 0.03});
  const Eigen::Vector3d shift(0.1, 0.2, -0.3);
  last.pose.R_CT = last.pose.R_CT * off;
  last.pose.p_CT += shift;
  const auto next = predict_from(spinning(0.0), last, after(25.0));
  ASSERT_TRUE(next.ok());
  EXPECT_LT(rotation_angle_rad(next.value().pose.R_CT, attitude(25.0) * off), 1e-7);
  EXPECT_LT((next.value().pose.p_CT - (pose_of(25.0).p_CT + shift)).norm(), 1e-7);
  // A model without doubt adds none: the last pose's sigmas are all.
  EXPECT_LT((next.value().covariance - last.covariance).norm(), 1e-12);
}

TEST(PredictFrom, AtTheLastPoseIsTheLastPose) {
  const PoseSample last = sample_at(20.0, 1e-3);
  const auto same = predict_from(spinning(1e-2), last, last.timestamp_ns);
  ASSERT_TRUE(same.ok());
  EXPECT_LT(rotation_angle_rad(same.value().pose.R_CT, last.pose.R_CT), 1e-9);
  EXPECT_LT((same.value().covariance - last.covariance).norm(), 1e-12);
}

TEST(Chi2Against, CountsAttitudeAndPositionBySigmas) {
  const RigidModel model = spinning(0.0);
  PoseSample sample = sample_at(10.0, 0.01);
  const PoseCovariance no_drift = PoseCovariance::Zero();
  EXPECT_NEAR(chi2_against(model, sample, no_drift).value(), 0.0, 1e-6);
  sample.pose.p_CT.x() += 0.03;  // 3 sigma
  EXPECT_NEAR(chi2_against(model, sample, no_drift).value(), 9.0, 1e-3);
  sample.pose.R_CT = so3_exp({0.0, 0.02, 0.0}) * sample.pose.R_CT;  // 2 sigma
  EXPECT_NEAR(chi2_against(model, sample, no_drift).value(), 13.0, 1e-3);
  // Drift as large as the noise halves it.
  EXPECT_NEAR(chi2_against(model, sample, sample.covariance).value(), 6.5, 1e-3);
  RigidModel rotation_only = model;
  rotation_only.translation_known = false;
  EXPECT_NEAR(chi2_against(rotation_only, sample, no_drift).value(), 4.0, 1e-3);
}

}  // namespace
}  // namespace polhode::model_prediction_test
