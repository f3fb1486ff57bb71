#include "app/dynamics_json.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "motion/body_dynamics.hpp"
#include "motion/published.hpp"

namespace polhode::platform {
namespace {

constexpr double kHorizonSigma_rad = 0.0873;  // 5 deg

const char* status_name(ModelStatus status) {
  switch (status) {
    case ModelStatus::kAccepted:
      return "accepted";
    case ModelStatus::kTooFewPoses:
      return "refused: too few poses";
    case ModelStatus::kNoFit:
      return "refused: no motion of a rigid body goes through the poses";
    case ModelStatus::kResidualsTooLarge:
      return "refused: the residuals are larger than the poses' sigmas, so these poses or their "
             "times are not "
             "those of a rigid body that nothing disturbs";
  }
  return "";
}

Json level_json(const ResidualLevel& level) {
  return {{"chi2_per_dof", level.chi2_per_dof},
          {"noise_scale", std::sqrt(level.scale2)},
          {"poses_per_independent_pose", level.correlation},
          {"outliers", level.outliers}};
}

/// A number with its sigma, or null where the data do not determine it.
Json estimated(const Estimated& e) {
  const bool known = e.observability != Observability::kUnobserved;
  return {{"value", known ? Json(e.value) : Json(nullptr)},
          {"sigma", known ? Json(e.sigma) : Json(nullptr)},
          {"observability", name(e.observability)}};
}

Json axes_json(const BodyDynamics& body) {
  Json axes = Json::array();
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const bool known = body.axes[i] != Observability::kUnobserved;
    axes.push_back({{"axis_T", known ? to_json(Eigen::Vector3d(body.R_TP.col(k))) : Json(nullptr)},
                    {"sigma_rad", known ? Json(body.sigma_axis_rad[i]) : Json(nullptr)},
                    {"observability", name(body.axes[i])}});
  }
  return axes;
}

Json path_json(const BodyDynamics& body,
               const RigidModel& model,
               const Eigen::Matrix3d& R_CI,
               double scale_sigma) {
  if (!model.translation_known) {
    return nullptr;
  }
  Json axes = Json::array();
  for (int k = 0; k < 3; ++k) {
    Estimated along = body.mass_centre[static_cast<std::size_t>(k)];
    along.sigma = std::hypot(along.sigma, scale_sigma * along.value);
    Json axis = estimated(along);
    axis["axis_T"] = to_json(Eigen::Vector3d(body.mass_centre_axes_T.col(k)));
    axes.push_back(axis);
  }
  const Eigen::Vector3d v_C = R_CI * body.v_I;
  const Eigen::Matrix3d covariance =
      R_CI * body.covariance_v_I * R_CI.transpose() + by_scale(v_C, scale_sigma);
  return {{"v_C", to_json(v_C)},
          {"sigma_v_C", sigmas(covariance)},
          {"speed", body.v_I.norm()},
          {"centre_of_mass", axes},
          {"residuals", level_json(model.position)}};
}

/// With the errors of the stated camera, alike in all directions.
MotionPrediction widened(MotionPrediction at, const SharedErrors& errors) {
  const double range = at.translation_known ? at.pose.p_CT.norm() : 0.0;
  const double size = range > 0.0 ? errors.body_radius / range : 0.0;
  widen(error_by(errors.camera, size), range, &at.covariance);
  return at;
}

Json row_json(const MotionPrediction& at,
              double ahead_s,
              const Eigen::Matrix3d& R_CI,
              double scale_sigma) {
  const Eigen::Quaterniond q(Eigen::Matrix3d(R_CI * at.pose.R_CT));
  const Eigen::Matrix3d attitude = R_CI * at.covariance.topLeftCorner<3, 3>() * R_CI.transpose();
  Json row{{"ahead_s", ahead_s},
           {"timestamp_ns", at.timestamp_ns},
           {"q_CT", {q.w(), q.x(), q.y(), q.z()}},
           {"sigma_att_rad", worst_sigma(attitude)},
           {"w_T_rad_s", to_json(at.w_T_rad_s)},
           {"sigma_rate_rad_s", worst_sigma(at.covariance_w_T)},
           {"p_CT", nullptr},
           {"sigma_pos", nullptr},
           {"v_C", nullptr},
           {"sigma_vel", nullptr}};
  if (at.translation_known) {
    const Eigen::Matrix3d position = at.covariance.bottomRightCorner<3, 3>();
    row["p_CT"] = to_json(R_CI * at.pose.p_CT);
    row["sigma_pos"] = worst_sigma(position + by_scale(at.pose.p_CT, scale_sigma));
    row["v_C"] = to_json(R_CI * at.v_I);
    row["sigma_vel"] = worst_sigma(at.covariance_v_I + by_scale(at.v_I, scale_sigma));
  }
  return row;
}

}  // namespace

Json to_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json sigmas(const Eigen::Matrix3d& covariance) {
  return to_json(Eigen::Vector3d(covariance.diagonal().cwiseMax(0.0).cwiseSqrt()));
}

const char* name(Observability observability) {
  switch (observability) {
    case Observability::kObserved:
      return "observed";
    case Observability::kWeak:
      return "weak";
    case Observability::kUnobserved:
      break;
  }
  return "unobserved";
}

Json fit_json(const RigidModel& model, const MotionOptions& options) {
  Json out{{"dynamics", options.dynamics == DynamicsKind::kOrbit ? "orbit" : "torque_free"},
           {"status", status_name(model.status)},
           {"poses", model.poses},
           {"span_s", model.span_s},
           {"attitude_residuals", nullptr}};
  if (model.accepted() || model.status == ModelStatus::kResidualsTooLarge) {
    out["attitude_residuals"] = level_json(model.attitude);
  }
  return out;
}

void add_dynamics(const RigidModel& model,
                  const Eigen::Matrix3d& R_CI,
                  double scale_sigma,
                  Json* out) {
  const Result<BodyDynamics> described = describe_dynamics(model);
  const BodyDynamics& body = described.value();
  Json& json = *out;
  json["reference_timestamp_ns"] = model.reference_ns;
  json["w_T_rad_s"] = to_json(model.reference.w_T_rad_s);
  json["sigma_w_T_rad_s"] = sigmas(model.covariance.block<3, 3>(3, 3));
  json["principal_axes_T"] = axes_json(body);
  json["inertia_ratios"] = {{"middle_over_least", estimated(body.middle_over_least)},
                            {"largest_over_least", estimated(body.largest_over_least)}};
  json["periods_s"] = {{"spin", estimated(body.spin_period_s)},
                       {"precession", estimated(body.precession_period_s)},
                       {"rotation", estimated(body.rotation_period_s)}};
  const bool axis_known = body.momentum_axis != Observability::kUnobserved;
  json["angular_momentum"] = {
      {"axis_C", axis_known ? to_json(R_CI * body.momentum_axis_I) : Json(nullptr)},
      {"sigma_rad", axis_known ? Json(body.sigma_momentum_axis_rad) : Json(nullptr)},
      {"observability", name(body.momentum_axis)}};
  json["translation"] = path_json(body, model, R_CI, scale_sigma);
}

void add_prediction(const RigidModel& model,
                    const Eigen::Matrix3d& R_CI,
                    const SharedErrors& errors,
                    Json* out) {
  constexpr std::array<double, 10> kAhead_s{
      0.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0};
  Json rows = Json::array();
  Json horizon = nullptr;
  bool sure = true;
  for (const double ahead_s : kAhead_s) {
    const auto at = predict_motion(model, model.reference_ns + std::llround(1e9 * ahead_s));
    if (!at) {
      break;
    }
    const MotionPrediction row = widened(at.value(), errors);
    rows.push_back(row_json(row, ahead_s, R_CI, errors.scale_sigma));
    sure = sure && worst_sigma(row.covariance.topLeftCorner<3, 3>()) < kHorizonSigma_rad;
    if (sure && ahead_s > 0.0) {
      horizon = ahead_s;
    }
  }
  (*out)["prediction_horizon_s"] = horizon;
  (*out)["prediction"] = rows;
}

}  // namespace polhode::platform
