#include "bus/dynamics_telemetry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "bus/packet_layout.hpp"
#include "bus/telemetry.hpp"
#include "geometry/so3.hpp"
#include "motion/body_dynamics.hpp"

namespace polhode::bus::dynamics_telemetry_test {
namespace {

const LengthUnit kMetres{.known = true, .metres_per_mu = 2.0, .number = 18};
const Eigen::Matrix3d kR_CI = so3_exp({0.3, -0.2, 0.5});

/// A body that tumbles, known as well as `sigma` says of every unknown.
RigidModel tumbling(double sigma) {
  RigidModel model;
  model.status = ModelStatus::kAccepted;
  model.translation_known = true;
  model.reference_ns = 5'000'000'000;
  model.reference.R_IT = so3_exp({0.1, 0.2, 0.3});
  model.reference.w_T_rad_s = {0.03, 0.05, 0.09};
  model.shape = shape_of(Eigen::Vector3d(0.25, 0.38, 0.47).asDiagonal());
  model.path << 1.0, 2.0, 20.0, 0.01, -0.02, 0.03, 0.1, -0.05, 0.02;
  model.covariance = sigma * sigma * ModelCovariance::Identity();
  model.attitude.chi2_per_dof = 1.2;
  model.position.chi2_per_dof = 0.9;
  model.poses = 120;
  model.span_s = 60.0;
  return model;
}

template <typename Packet>
Packet through_the_bus(Packet packet) {
  std::vector<std::uint8_t> octets(Packet::layout().octets);
  EXPECT_EQ(encode(Packet::layout(), &packet, {}, octets), octets.size());
  Packet back;
  const Result<PacketHeader> header = decode(Packet::layout(), octets, &back);
  EXPECT_TRUE(header.ok()) << (header ? "" : header.error().message);
  return back;
}

TEST(ModelPacketOf, AKnownMotionHasAllFlags_AndTheDescriptionsValues) {
  const RigidModel model = tumbling(1e-4);
  const ModelPacket packet = through_the_bus(to_packet(model, kR_CI, kMetres));
  const BodyDynamics body = describe_dynamics(model).value();
  EXPECT_EQ(packet.flags, model_layout::kFlagsUsed);
  EXPECT_EQ(packet.timestamp_ns, model.reference_ns);
  EXPECT_EQ(packet.dynamics, 2);
  EXPECT_EQ(packet.refusal, 0);
  EXPECT_EQ(packet.inertia_ratio[0], body.middle_over_least.value);
  EXPECT_EQ(packet.inertia_ratio[1], body.largest_over_least.value);
  EXPECT_NEAR(packet.inertia_ratio[1], 0.47 / 0.25, 1e-9);
  EXPECT_EQ(packet.period_spin_s, body.spin_period_s.value);
  EXPECT_EQ(packet.period_precession_s, body.precession_period_s.value);
  const Eigen::Quaterniond q_TB(packet.q_TB[0], packet.q_TB[1], packet.q_TB[2], packet.q_TB[3]);
  EXPECT_LT(rotation_angle_rad(q_TB.toRotationMatrix(), body.R_TP), 1e-9);
  const Eigen::Vector3d axis_C = kR_CI * body.momentum_axis_I;
  EXPECT_NEAR(packet.momentum_axis_C[1], axis_C.y(), 1e-12);
  EXPECT_EQ(packet.class_inertia, (std::array<std::uint8_t, 2>{2, 2}));
  EXPECT_EQ(packet.class_axes, (std::array<std::uint8_t, 3>{2, 2, 2}));
  EXPECT_EQ(packet.class_mass_centre, (std::array<std::uint8_t, 3>{2, 2, 2}));
  EXPECT_FLOAT_EQ(packet.chi2_per_dof[0], 1.2F);
  EXPECT_EQ(packet.poses, 120U);
}

TEST(ModelPacketOf, LengthsAreInTheUnitAndInC) {
  const ModelPacket packet = through_the_bus(to_packet(tumbling(1e-4), kR_CI, kMetres));
  const Eigen::Vector3d v_C = 2.0 * (kR_CI * Eigen::Vector3d(0.01, -0.02, 0.03));
  EXPECT_NEAR(packet.v_C[0], v_C.x(), 1e-12);
  EXPECT_NEAR(packet.c_T[0], 0.2, 1e-9);
  EXPECT_NEAR(packet.cov_v[0], 4e-8, 1e-12);
  EXPECT_NEAR(packet.cov_c[5], 4e-8, 1e-12);
  EXPECT_NEAR(packet.cov_w[0], 1e-8, 1e-12);
}

// verifies: BUS-08
TEST(PacketsOfLengths, HoldTheErrorOfTheScaleItself) {
  const LengthUnit loose{.known = true, .metres_per_mu = 2.0, .relative_sigma = 0.1};
  const ModelPacket model = through_the_bus(to_packet(tumbling(1e-4), kR_CI, loose));
  EXPECT_NEAR(model.cov_v[0], 4e-8 + 0.01 * model.v_C[0] * model.v_C[0], 1e-11);
  EXPECT_NEAR(model.cov_c[1], 0.01 * model.c_T[0] * model.c_T[1], 1e-9);
  const MotionPrediction there{
      .pose = {.R_CT = Eigen::Matrix3d::Identity(), .p_CT = {1.0, 2.0, 20.0}},
      .translation_known = true};
  const PredictionPacket ahead = through_the_bus(to_packet(there, tumbling(1e-4), kR_CI, loose));
  EXPECT_NEAR(ahead.cov_pose[20], 0.01 * ahead.p_CT[2] * ahead.p_CT[2], 1e-5);
}

TEST(ModelPacketOf, WhatTheDataDoNotTellIsZeroAndSaysSo) {
  const ModelPacket packet = through_the_bus(to_packet(tumbling(1.5), kR_CI, {}));
  EXPECT_EQ(packet.flags, model_layout::kFlagRate | model_layout::kFlagVelocity);
  EXPECT_EQ(packet.inertia_ratio, (std::array<double, 2>{}));
  EXPECT_EQ(packet.q_TB, (std::array<double, 4>{}));
  EXPECT_EQ(packet.c_T, (std::array<double, 3>{}));
  EXPECT_EQ(packet.momentum_axis_C, (std::array<double, 3>{}));
  EXPECT_EQ(packet.class_spin, 0);
  EXPECT_EQ(packet.class_mass_centre, (std::array<std::uint8_t, 3>{}));
}

TEST(ModelPacketOf, ADirectionOfTheMassCentreThatIsNotKnownIsLeftOut) {
  RigidModel model = tumbling(1e-4);
  constexpr int kAlongZ = kRotationUnknowns + 8;
  model.covariance(kAlongZ, kAlongZ) = 0.95 * model.mass_centre_sigma * model.mass_centre_sigma;
  const ModelPacket packet = through_the_bus(to_packet(model, kR_CI, {}));
  EXPECT_TRUE((packet.flags & model_layout::kFlagMassCentre) != 0);
  EXPECT_EQ(packet.class_mass_centre, (std::array<std::uint8_t, 3>{2, 2, 0}));
  EXPECT_NEAR(packet.c_T[0], 0.1, 1e-9);
  EXPECT_NEAR(packet.c_T[2], 0.0, 1e-9);
  EXPECT_NEAR(packet.cov_c[5], 0.95, 1e-6);
}

TEST(ModelPacketOf, ARefusedFitSaysOnlyWhy) {
  RigidModel model = tumbling(1e-4);
  model.status = ModelStatus::kResidualsTooLarge;
  const ModelPacket packet = through_the_bus(to_packet(model, kR_CI, kMetres));
  EXPECT_EQ(packet.flags, model_layout::kFlagScaleKnown);
  EXPECT_EQ(packet.refusal, 3);
  EXPECT_EQ(packet.dynamics, 0);
  EXPECT_EQ(packet.w_T_rad_s, (std::array<double, 3>{}));
}

MotionPrediction ahead(double sigma_att_rad, double sigma_position) {
  MotionPrediction prediction;
  prediction.timestamp_ns = 65'000'000'000;
  prediction.pose = {.R_CT = so3_exp({1.0, 2.0, -0.5}), .p_CT = {1.0, 2.0, 20.0}};
  prediction.covariance.diagonal().head<3>().setConstant(sigma_att_rad * sigma_att_rad);
  prediction.covariance.diagonal().tail<3>().setConstant(sigma_position * sigma_position);
  prediction.w_T_rad_s = {0.1, 0.2, 0.3};
  prediction.covariance_w_T = 1e-6 * Eigen::Matrix3d::Identity();
  prediction.translation_known = true;
  return prediction;
}

TEST(PredictionPacketOf, IsSeenFromAxesThatKeepTheirAttitude) {
  const MotionPrediction prediction = ahead(0.1, 0.5);
  const PredictionPacket packet =
      through_the_bus(to_packet(prediction, tumbling(1e-4), kR_CI, kMetres));
  EXPECT_EQ(packet.flags,
            prediction_layout::kFlagsUsed | 2U << prediction_layout::kScaleNumberShift);
  EXPECT_EQ(packet.predicted_timestamp_ns, prediction.timestamp_ns);
  const Eigen::Quaterniond q(packet.q_CT[0], packet.q_CT[1], packet.q_CT[2], packet.q_CT[3]);
  EXPECT_GE(packet.q_CT[0], 0.0);
  EXPECT_LT(rotation_angle_rad(q.toRotationMatrix(), kR_CI * prediction.pose.R_CT), 1e-9);
  const Eigen::Vector3d p_C = 2.0 * (kR_CI * prediction.pose.p_CT);
  EXPECT_NEAR(packet.p_CT[2], p_C.z(), 1e-12);
  EXPECT_NEAR(packet.cov_pose[0], 0.01, 1e-7);
  EXPECT_NEAR(packet.cov_pose[20], 1.0, 1e-6);
  EXPECT_EQ(packet.w_T_rad_s, (std::array<double, 3>{0.1, 0.2, 0.3}));
  EXPECT_EQ(packet.poses, 120);
}

TEST(PredictionPacketOf, WhatMayBeOffByTooMuchIsNotShown) {
  const PredictionPacket turned =
      through_the_bus(to_packet(ahead(0.6, 0.5), tumbling(1e-4), kR_CI, kMetres));
  EXPECT_EQ(turned.flags & prediction_layout::kFlagAttitude, 0);
  EXPECT_NE(turned.flags & prediction_layout::kFlagPosition, 0);
  EXPECT_EQ(turned.q_CT, (std::array<double, 4>{}));
  EXPECT_EQ(turned.cov_pose[0], 0.0F);
  EXPECT_GT(turned.cov_pose[20], 0.0F);
  const PredictionPacket gone =
      through_the_bus(to_packet(ahead(0.1, 11.0), tumbling(1e-4), kR_CI, kMetres));
  EXPECT_NE(gone.flags & prediction_layout::kFlagAttitude, 0);
  EXPECT_EQ(gone.flags & prediction_layout::kFlagPosition, 0);
  EXPECT_EQ(gone.p_CT, (std::array<double, 3>{}));
  EXPECT_EQ(gone.cov_pose[20], 0.0F);
}

TEST(PredictionPacketOf, TheLastPosesAloneHasNoRate) {
  PosePrediction local;
  local.pose = ahead(0.1, 0.1).pose;
  local.covariance = ahead(0.1, 0.1).covariance;
  local.rotation_poses = 70'000;  // more than its field holds
  const PredictionPacket packet = through_the_bus(to_packet(local, {}));
  EXPECT_EQ(packet.flags, prediction_layout::kFlagAttitude | prediction_layout::kFlagPosition);
  EXPECT_EQ(packet.dynamics, kDynamicsLocal);
  EXPECT_EQ(packet.poses, 0xFFFF);
}

}  // namespace
}  // namespace polhode::bus::dynamics_telemetry_test
