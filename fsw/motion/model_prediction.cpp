// A fitted model at other times than its own.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "geometry/so3.hpp"
#include "motion/residual_level.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {
namespace {

using Rows = Eigen::Matrix<double, 3, kModelUnknownsAll>;

/// State and derivatives at another time.
struct Reached {
  RotationState state;
  RotationDerivative derivative;
  Eigen::Matrix<double, 6, 6> transition;
};

bool reach(const RigidModel& model, std::int64_t timestamp_ns, Reached* to) {
  if (!model.accepted()) {
    return false;
  }
  const double ahead_s = seconds_between(model.reference_ns, timestamp_ns);
  to->state = model.reference;
  to->derivative = RotationDerivative::at_reference();
  to->transition = translation_transition(model.orbit, 0.0, ahead_s);
  return advance(inertia_of(model.shape), model.orbit, ahead_s, to->state, &to->derivative);
}

Rows turning_rows(const RotationJacobian& part) {
  Rows rows = Rows::Zero();
  rows.leftCols<kRotationUnknowns>() = part;
  return rows;
}

Eigen::Matrix3d covariance_of(const Rows& rows, const RigidModel& model) {
  const Eigen::Matrix3d covariance = rows * model.covariance * rows.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

/// T's origin lies at -R c from the mass centre; its velocity there is -R (w x c).
void add_path(const RigidModel& model, const Reached& at, Rows* by_all, MotionPrediction* out) {
  const Eigen::Matrix<double, 6, 1> centre = at.transition * model.path.head<6>();
  const Eigen::Vector3d c_T = model.path.tail<3>();
  const Eigen::Matrix3d& R = at.state.R_IT;
  const Eigen::Vector3d& w = at.state.w_T_rad_s;
  out->pose.p_CT = centre.head<3>() - R * c_T;
  out->v_I = centre.tail<3>() - R * w.cross(c_T);
  Rows position = turning_rows(hat(R * c_T) * at.derivative.attitude_I);
  position.middleCols<6>(kRotationUnknowns) = at.transition.topRows<3>();
  position.rightCols<3>() = -R;
  Rows velocity = turning_rows(hat(R * w.cross(c_T)) * at.derivative.attitude_I +
                               R * hat(c_T) * at.derivative.rate_T);
  velocity.middleCols<6>(kRotationUnknowns) = at.transition.bottomRows<3>();
  velocity.rightCols<3>() = -R * hat(w);
  out->covariance_v_I = covariance_of(velocity, model);
  *by_all = position;
  out->translation_known = true;
}

MotionPrediction describe(const RigidModel& model,
                          const Reached& at,
                          std::int64_t timestamp_ns,
                          Eigen::Matrix<double, 6, kModelUnknownsAll>* pose_rows) {
  MotionPrediction out;
  out.timestamp_ns = timestamp_ns;
  out.pose.R_CT = at.state.R_IT;
  out.w_T_rad_s = at.state.w_T_rad_s;
  out.covariance_w_T = covariance_of(turning_rows(at.derivative.rate_T), model);
  pose_rows->setZero();
  pose_rows->topRows<3>() = turning_rows(at.derivative.attitude_I);
  if (model.translation_known) {
    Rows position;
    add_path(model, at, &position, &out);
    pose_rows->bottomRows<3>() = position;
  }
  const PoseCovariance covariance = *pose_rows * model.covariance * pose_rows->transpose();
  out.covariance = 0.5 * (covariance + covariance.transpose());
  return out;
}

}  // namespace

bool move_reference(std::int64_t timestamp_ns, RigidModel& model) {
  Reached to;
  if (!reach(model, timestamp_ns, &to)) {
    return false;
  }
  ModelCovariance transition = ModelCovariance::Identity();
  transition.topLeftCorner<3, kRotationUnknowns>() = to.derivative.attitude_I;
  transition.block<3, kRotationUnknowns>(3, 0) = to.derivative.rate_T;
  transition.block<6, 6>(kRotationUnknowns, kRotationUnknowns) = to.transition;
  const ModelCovariance moved = transition * model.covariance * transition.transpose();
  const double ahead_s = seconds_between(model.reference_ns, timestamp_ns);
  model.covariance = 0.5 * (moved + moved.transpose());
  model.orbit.R_IH = model.orbit.R_IH_at(ahead_s);
  model.reference_ns = timestamp_ns;
  model.reference = to.state;
  model.reference.time_s = 0.0;
  model.path.head<6>() = (to.transition * model.path.head<6>()).eval();
  return true;
}

Result<MotionPrediction> predict_motion(const RigidModel& model, std::int64_t timestamp_ns) {
  Reached at;
  if (!reach(model, timestamp_ns, &at)) {
    return ErrorCode::kDegenerate;
  }
  Eigen::Matrix<double, 6, kModelUnknownsAll> rows;
  return describe(model, at, timestamp_ns, &rows);
}

MotionPrediction predict_at(const RigidModel& model,
                            const RotationState& state,
                            const RotationDerivative& derivative) {
  const Reached at{.state = state,
                   .derivative = derivative,
                   .transition = translation_transition(model.orbit, 0.0, state.time_s)};
  Eigen::Matrix<double, 6, kModelUnknownsAll> rows;
  return describe(model, at, model.reference_ns + std::llround(1e9 * state.time_s), &rows);
}

Result<MotionPrediction> predict_from(const RigidModel& model,
                                      const PoseSample& last,
                                      std::int64_t timestamp_ns) {
  RigidModel from = model;
  Reached at;
  if (!move_reference(last.timestamp_ns, from) || !reach(from, timestamp_ns, &at)) {
    return ErrorCode::kDegenerate;
  }
  Eigen::Matrix<double, 6, kModelUnknownsAll> rows_last;
  Eigen::Matrix<double, 6, kModelUnknownsAll> rows;
  Reached here;
  (void)reach(from, last.timestamp_ns, &here);
  const MotionPrediction before = describe(from, here, last.timestamp_ns, &rows_last);
  MotionPrediction out = describe(from, at, timestamp_ns, &rows);
  // R = R_model R_model,last^T R_last: errors of the last pose, and of the motion in between.
  const Eigen::Matrix3d R_between = out.pose.R_CT * before.pose.R_CT.transpose();
  rows.topRows<3>() -= R_between * rows_last.topRows<3>();
  rows.bottomRows<3>() -= rows_last.bottomRows<3>();
  PoseCovariance carried = PoseCovariance::Identity();
  carried.topLeftCorner<3, 3>() = R_between;
  const PoseCovariance covariance =
      rows * from.covariance * rows.transpose() + carried * last.covariance * carried.transpose();
  out.covariance = 0.5 * (covariance + covariance.transpose());
  out.pose.R_CT = R_between * last.pose.R_CT;
  out.pose.p_CT = last.pose.p_CT + (out.pose.p_CT - before.pose.p_CT);
  return out;
}

Result<MotionPrediction> predict_on(const RigidModel& model,
                                    const PoseSample& from,
                                    const PoseCovariance& drift_I,
                                    std::int64_t timestamp_ns) {
  Result<MotionPrediction> predicted = predict_from(model, from, timestamp_ns);
  if (predicted) {
    const double part =
        rotation_angle_rad(from.pose.R_CT, predicted.value().pose.R_CT) / kFaceAngle_rad;
    predicted.value().covariance += part * part * drift_I;
  }
  return predicted;
}

double chi2_between(const MotionPrediction& predicted, const PoseSample& sample) {
  Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();
  error.head<3>() = so3_log(sample.pose.R_CT * predicted.pose.R_CT.transpose());
  if (predicted.translation_known) {
    error.tail<3>() = sample.pose.p_CT - predicted.pose.p_CT;
  }
  const PoseCovariance total = sample.covariance + predicted.covariance;
  return error.dot(total.ldlt().solve(error));
}

Result<double> chi2_against(const RigidModel& model,
                            const PoseSample& sample,
                            const PoseCovariance& drift) {
  Result<MotionPrediction> predicted = predict_motion(model, sample.timestamp_ns);
  if (!predicted) {
    return predicted.error();
  }
  predicted.value().covariance += drift;
  return chi2_between(predicted.value(), sample);
}

}  // namespace polhode
