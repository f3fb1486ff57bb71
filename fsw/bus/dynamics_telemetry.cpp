#include "bus/dynamics_telemetry.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "bus/narrow.hpp"
#include "bus/packet_layout.hpp"
#include "motion/body_dynamics.hpp"

namespace polhode::bus {
namespace {

/// Rows of the upper triangle, one after the other.
template <std::size_t kCount, typename Matrix>
void put_upper_triangle(const Matrix& m, std::array<float, kCount>* out) {
  std::size_t i = 0;
  for (Eigen::Index row = 0; row < m.rows(); ++row) {
    for (Eigen::Index column = row; column < m.cols(); ++column) {
      (*out)[i++] = static_cast<float>(m(row, column));
    }
  }
}

/// Covariance of a length by the scale's error.
Eigen::Matrix3d scale_covariance(const Eigen::Vector3d& length, const LengthUnit& unit) {
  return unit.relative_sigma * unit.relative_sigma * length * length.transpose();
}

std::uint8_t class_number(Observability observability) {
  return static_cast<std::uint8_t>(observability);
}

bool known(Observability observability) { return observability != Observability::kUnobserved; }

void put_axes(const BodyDynamics& body, ModelPacket* packet) {
  for (std::size_t k = 0; k < 3; ++k) {
    packet->class_axes[k] = class_number(body.axes[k]);
    if (known(body.axes[k])) {
      packet->flags |= model_layout::kFlagAxes;
      packet->sigma_axes_rad[k] = static_cast<float>(body.sigma_axis_rad[k]);
    }
  }
  packet->q_TB = quaternion_of(body.R_TP);
}

void put_inertia(const BodyDynamics& body, ModelPacket* packet) {
  const std::array<const Estimated*, 2> ratios{&body.middle_over_least, &body.largest_over_least};
  for (std::size_t k = 0; k < 2; ++k) {
    packet->class_inertia[k] = class_number(ratios[k]->observability);
    if (known(ratios[k]->observability)) {
      packet->flags |= model_layout::kFlagInertia;
      packet->inertia_ratio[k] = ratios[k]->value;
      packet->sigma_inertia_ratio[k] = static_cast<float>(ratios[k]->sigma);
    }
  }
}

void put_period(const Estimated& period_s,
                std::uint8_t flag,
                double* value,
                float* sigma,
                ModelPacket* packet) {
  if (known(period_s.observability)) {
    packet->flags |= flag;
    *value = period_s.value;
    *sigma = static_cast<float>(period_s.sigma);
  }
}

void put_periods(const BodyDynamics& body, ModelPacket* packet) {
  packet->class_spin = class_number(body.spin_period_s.observability);
  packet->class_precession = class_number(body.precession_period_s.observability);
  put_period(body.spin_period_s,
             model_layout::kFlagSpin,
             &packet->period_spin_s,
             &packet->sigma_period_spin_s,
             packet);
  put_period(body.precession_period_s,
             model_layout::kFlagPrecession,
             &packet->period_precession_s,
             &packet->sigma_period_precession_s,
             packet);
}

void put_momentum(const BodyDynamics& body, const Eigen::Matrix3d& R_CI, ModelPacket* packet) {
  packet->class_momentum = class_number(body.momentum_axis);
  if (known(body.momentum_axis)) {
    packet->momentum_axis_C = to_array(R_CI * body.momentum_axis_I);
    packet->sigma_momentum_axis_rad = static_cast<float>(body.sigma_momentum_axis_rad);
  }
}

void put_translation(const BodyDynamics& body,
                     const RigidModel& model,
                     const Eigen::Matrix3d& R_CI,
                     const LengthUnit& lengths,
                     ModelPacket* packet) {
  const double unit = lengths.metres_per_mu;
  const Eigen::Vector3d v_C = unit * (R_CI * body.v_I);
  packet->flags |= model_layout::kFlagVelocity;
  packet->v_C = to_array(v_C);
  const Eigen::Matrix3d covariance_v_C =
      unit * unit * (R_CI * body.covariance_v_I * R_CI.transpose());
  put_upper_triangle(Eigen::Matrix3d(covariance_v_C + scale_covariance(v_C, lengths)),
                     &packet->cov_v);
  Eigen::Vector3d c_T = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Estimated& along = body.mass_centre[k];
    packet->class_mass_centre[k] = class_number(along.observability);
    if (known(along.observability)) {
      packet->flags |= model_layout::kFlagMassCentre;
      c_T += along.value * body.mass_centre_axes_T.col(static_cast<Eigen::Index>(k));
    }
  }
  packet->c_T = to_array(unit * c_T);
  const Eigen::Matrix3d covariance_c_T = unit * unit * model.covariance.bottomRightCorner<3, 3>();
  put_upper_triangle(Eigen::Matrix3d(covariance_c_T + scale_covariance(unit * c_T, lengths)),
                     &packet->cov_c);
}

std::uint8_t refusal_of(const RigidModel& model) { return static_cast<std::uint8_t>(model.status); }

/// @param pose_C, covariance  in C and the packet's unit; the covariance without the scale's error.
void put_pose(const Pose& pose_C,
              const PoseCovariance& covariance,
              const LengthUnit& unit,
              bool translation_known,
              PredictionPacket* packet) {
  PoseCovariance shown = covariance;
  shown.bottomRightCorner<3, 3>() += scale_covariance(pose_C.p_CT, unit);
  const double sigma_position = worst_sigma(shown.bottomRightCorner<3, 3>());
  const bool position =
      translation_known && sigma_position < kPositionSigmaMax * pose_C.p_CT.norm();
  if (position) {
    packet->flags |= prediction_layout::kFlagPosition;
    packet->p_CT = to_array(pose_C.p_CT);
  } else {
    shown.bottomRows<3>().setZero();
    shown.rightCols<3>().setZero();
  }
  if (worst_sigma(covariance.topLeftCorner<3, 3>()) < kAttitudeSigmaMax_rad) {
    packet->flags |= prediction_layout::kFlagAttitude;
    packet->q_CT = quaternion_of(pose_C.R_CT);
  } else {
    shown.topRows<3>().setZero();
    shown.leftCols<3>().setZero();
  }
  put_upper_triangle(shown, &packet->cov_pose);
}

Pose in_unit(const Pose& pose, double unit) {
  return {.R_CT = pose.R_CT, .p_CT = unit * pose.p_CT};
}

/// The covariance in C's axes and the unit.
PoseCovariance in_unit(const PoseCovariance& covariance_I,
                       const Eigen::Matrix3d& R_CI,
                       double unit) {
  PoseCovariance by = PoseCovariance::Zero();
  by.topLeftCorner<3, 3>() = R_CI;
  by.bottomRightCorner<3, 3>() = unit * R_CI;
  return by * covariance_I * by.transpose();
}

/// The unit of the lengths of a prediction or of a point, in its packet's flags.
std::uint8_t scale_flags(bool known, std::uint32_t scale_number) {
  namespace flag = prediction_layout;
  static_assert(flag::kFlagScaleKnown == point_layout::kFlagScaleKnown);
  const unsigned number = scale_number % flag::kScaleNumbers << flag::kScaleNumberShift;
  return static_cast<std::uint8_t>(number | (known ? flag::kFlagScaleKnown : 0U));
}

}  // namespace

std::uint8_t dynamics_of(const RigidModel& model) {
  return model.orbit.active() ? kDynamicsOrbit : kDynamicsTorqueFree;
}

ModelPacket to_packet(const RigidModel& model,
                      const Eigen::Matrix3d& R_CI,
                      const LengthUnit& unit) {
  ModelPacket packet;
  packet.timestamp_ns = model.reference_ns;
  packet.refusal = refusal_of(model);
  packet.flags = unit.known ? model_layout::kFlagScaleKnown : std::uint8_t{0};
  const Result<BodyDynamics> described = describe_dynamics(model);
  if (!described) {
    return packet;
  }
  const BodyDynamics& body = described.value();
  packet.dynamics = dynamics_of(model);
  packet.poses = static_cast<std::uint32_t>(model.poses);
  packet.span_s = static_cast<float>(model.span_s);
  packet.chi2_per_dof[0] = static_cast<float>(model.attitude.chi2_per_dof);
  packet.flags |= model_layout::kFlagRate;
  packet.w_T_rad_s = to_array(model.reference.w_T_rad_s);
  put_upper_triangle(Eigen::Matrix3d(model.covariance.block<3, 3>(3, 3)), &packet.cov_w);
  put_axes(body, &packet);
  put_inertia(body, &packet);
  put_periods(body, &packet);
  put_momentum(body, R_CI, &packet);
  if (model.translation_known) {
    packet.chi2_per_dof[1] = static_cast<float>(model.position.chi2_per_dof);
    put_translation(body, model, R_CI, unit, &packet);
  }
  return packet;
}

PredictionPacket to_packet(const MotionPrediction& prediction,
                           const RigidModel& model,
                           const Eigen::Matrix3d& R_CI,
                           const LengthUnit& unit) {
  PredictionPacket packet;
  packet.predicted_timestamp_ns = prediction.timestamp_ns;
  packet.dynamics = dynamics_of(model);
  packet.poses = clipped(model.poses);
  packet.flags = prediction_layout::kFlagRate | scale_flags(unit.known, unit.number);
  packet.w_T_rad_s = to_array(prediction.w_T_rad_s);
  put_upper_triangle(prediction.covariance_w_T, &packet.cov_w);
  const Pose pose_C{.R_CT = R_CI * prediction.pose.R_CT, .p_CT = R_CI * prediction.pose.p_CT};
  put_pose(in_unit(pose_C, unit.metres_per_mu),
           in_unit(prediction.covariance, R_CI, unit.metres_per_mu),
           unit,
           prediction.translation_known,
           &packet);
  return packet;
}

PointPacket to_packet(const PointState& point) {
  namespace flag = point_layout;
  PointPacket packet;
  packet.timestamp_ns = point.from_timestamp_ns;
  packet.predicted_timestamp_ns = point.timestamp_ns;
  packet.dynamics = point.dynamics;
  packet.flags = static_cast<std::uint8_t>(scale_flags(point.scale_known, point.scale_number) |
                                           (point.position_valid ? flag::kFlagPosition : 0U) |
                                           (point.velocity_valid ? flag::kFlagVelocity : 0U) |
                                           (point.normal_valid ? flag::kFlagNormal : 0U));
  packet.p_C = point.p_C;
  packet.v_C = point.v_C;
  packet.normal_C = point.normal_C;
  packet.cov_p = narrowed(point.cov_p);
  packet.cov_v = narrowed(point.cov_v);
  packet.sigma_normal_rad = static_cast<float>(point.sigma_normal_rad);
  return packet;
}

PredictionPacket to_packet(const PosePrediction& prediction, const LengthUnit& unit) {
  PredictionPacket packet;
  packet.dynamics = kDynamicsLocal;
  packet.poses = clipped(prediction.rotation_poses);
  packet.flags = scale_flags(unit.known, unit.number);
  put_pose(in_unit(prediction.pose, unit.metres_per_mu),
           in_unit(prediction.covariance, Eigen::Matrix3d::Identity(), unit.metres_per_mu),
           unit,
           true,
           &packet);
  return packet;
}

}  // namespace polhode::bus
