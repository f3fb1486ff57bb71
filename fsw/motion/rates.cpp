#include "motion/rates.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"
#include "motion/local_fit.hpp"

namespace polhode {
namespace {

using Series = FixedVector<SeriesPoint, limits::kMotionPoses>;

// Rotation vectors relative to the reference are unique below pi; 0.5 rad of margin for noise and bend.
constexpr double kPsiMax_rad = 2.6;
// Bodies that turn far between frames exceed the window's angle at once; four poses are needed to test a linear rate.
constexpr std::size_t kPosesMin = 4;
// Of a free body |dw/dt| <= |w|^2 / sqrt(3), because (I_j - I_k) / I_i <= 1; a typical body has a moderate part of it.
constexpr double kFreeAcceleration = 0.25;

bool information_of(const Eigen::Matrix3d& covariance, Eigen::Matrix3d& information) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  if (!covariance.allFinite() || llt.info() != Eigen::Success) {
    return false;
  }
  information = llt.solve(Eigen::Matrix3d::Identity());
  return information.allFinite();
}

struct Window {
  Series rotation;
  Series position;
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();  ///< reference attitude
};

/// Adds one pose. False when its covariance is not usable.
bool add(const PoseSample& sample, double tau_s, bool with_rotation, Window& window) {
  SeriesPoint position{.tau_s = tau_s, .value = sample.pose.p_CT, .information = {}};
  if (!information_of(sample.covariance.bottomRightCorner<3, 3>(), position.information) ||
      !window.position.push_back(position)) {
    return false;
  }
  if (!with_rotation) {
    return true;
  }
  SeriesPoint rotation{.tau_s = tau_s, .value = so3_log(window.R_CT.transpose() * sample.pose.R_CT), .information = {}};
  // exp(phi) R = R_ref exp(R_ref^T phi) exp(psi): phi appears in psi as J_l(psi)^-1 R_ref^T phi.
  const Eigen::Matrix3d to_phi = window.R_CT * so3_left_jacobian(rotation.value);
  Eigen::Matrix3d information_phi;
  if (!information_of(sample.covariance.topLeftCorner<3, 3>(), information_phi)) {
    return false;
  }
  rotation.information = to_phi.transpose() * information_phi * to_phi;
  return window.rotation.push_back(rotation);
}

/// Poses around `index`, nearest in time first, at most window_poses_max; rotation ends where the angle gets too large.
bool collect(std::span<const PoseSample> history, std::size_t index, const MotionOptions& options, Window& window) {
  window.R_CT = history[index].pose.R_CT;
  std::size_t before = index;     // next candidate is before - 1
  std::size_t after = index + 1;  // next candidate
  bool rotation_open = true;
  const auto limit = std::min(limits::kMotionPoses, static_cast<std::size_t>(std::max(2, options.window_poses_max)));
  std::size_t next = index;
  for (std::size_t count = 0; count < limit; ++count) {
    const double tau_s = seconds_between(history[index].timestamp_ns, history[next].timestamp_ns);
    const double angle_rad = rotation_angle_rad(window.R_CT, history[next].pose.R_CT);
    const double angle_max_rad = window.rotation.size() < kPosesMin ? kPsiMax_rad : options.window_angle_max_rad;
    rotation_open = rotation_open && angle_rad <= angle_max_rad;
    if (!add(history[next], tau_s, rotation_open, window)) {
      return false;
    }
    const bool has_before = before > 0;
    const bool has_after = after < history.size();
    if (!has_before && !has_after) {
      break;
    }
    const bool take_before =
        has_before && (!has_after || history[index].timestamp_ns - history[before - 1].timestamp_ns <=
                                         history[after].timestamp_ns - history[index].timestamp_ns);
    next = take_before ? --before : after++;
  }
  return true;
}

/// What an untested constant rate may hide: the rate's change, in units of |w|^2.
double hidden_acceleration_rad_s2(const LocalFit& rotation) {
  return rotation.degrees_of_freedom == 0 && rotation.degree == 1
             ? kFreeAcceleration * rotation.coefficients[1].squaredNorm()
             : 0.0;
}

}  // namespace

double worst_sigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()(2)));
}

Result<RateEstimate> estimate_rates_at(std::span<const PoseSample> history,
                                       std::size_t index,
                                       const MotionOptions& options) {
  POLHODE_ASSERT(history.empty() || index < history.size(), index);
  if (history.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  Window window;
  if (!collect(history, index, options, window)) {
    return ErrorCode::kDegenerate;
  }
  const LocalTarget rate{.tau_s = 0.0, .derivative = 1};
  const Result<LocalFit> rotation = fit_local(window.rotation.view(), rate);
  const Result<LocalFit> position = fit_local(window.position.view(), rate);
  if (!rotation || !position) {
    return rotation ? position.error() : rotation.error();
  }
  const LocalFit& turn = rotation.value();
  const LocalFit& path = position.value();
  // The fitted attitude is R_ref exp(offset), and w_T = J_r(offset) d psi / dt there.
  const Eigen::Vector3d offset = turn.coefficients[0];
  RateEstimate rates;
  rates.w_T_rad_s = so3_left_jacobian(-offset) * turn.estimate;
  const double hidden = 0.5 * turn.span_s * hidden_acceleration_rad_s2(turn);
  rates.covariance_w_T = turn.covariance + hidden * hidden * Eigen::Matrix3d::Identity();
  rates.v_C = path.estimate;
  rates.covariance_v_C = path.covariance;
  rates.pose.R_CT = window.R_CT * so3_exp(offset);
  rates.pose.p_CT = path.coefficients[0];
  rates.rotation_poses = turn.points;
  rates.position_poses = path.points;
  rates.rotation_span_s = turn.span_s;
  rates.position_span_s = path.span_s;
  rates.rotation_misfit = turn.misfit;
  rates.position_misfit = path.misfit;
  return rates;
}

Result<RateEstimate> estimate_rates(std::span<const PoseSample> history, const MotionOptions& options) {
  return estimate_rates_at(history, history.empty() ? 0 : history.size() - 1, options);
}

Result<PosePrediction> predict_pose(std::span<const PoseSample> history,
                                    std::int64_t timestamp_ns,
                                    const MotionOptions& options) {
  if (history.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  const double ahead_s = seconds_between(history.back().timestamp_ns, timestamp_ns);
  Window window;
  if (ahead_s < 0.0 || !collect(history, history.size() - 1, options, window)) {
    return ErrorCode::kDegenerate;
  }
  const LocalTarget later{.tau_s = ahead_s, .derivative = 0};
  const Result<LocalFit> rotation = fit_local(window.rotation.view(), later);
  const Result<LocalFit> position = fit_local(window.position.view(), later);
  if (!rotation || !position) {
    return rotation ? position.error() : rotation.error();
  }
  const LocalFit& turn = rotation.value();
  // A constant rate through two points misses a t (t + span) / 2 at the time t after the later one.
  const double hidden = 0.5 * ahead_s * (ahead_s + turn.span_s) * hidden_acceleration_rad_s2(turn);
  const Eigen::Matrix3d covariance_psi = turn.covariance + hidden * hidden * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d to_phi = window.R_CT * so3_left_jacobian(turn.estimate);
  PosePrediction prediction;
  prediction.pose.R_CT = window.R_CT * so3_exp(turn.estimate);
  prediction.pose.p_CT = position.value().estimate;
  prediction.covariance.topLeftCorner<3, 3>() = to_phi * covariance_psi * to_phi.transpose();
  prediction.covariance.bottomRightCorner<3, 3>() = position.value().covariance;
  prediction.rotation_poses = turn.points;
  prediction.position_poses = position.value().points;
  return prediction;
}

void publish(const RateEstimate& rates, MotionState& state) {
  for (std::size_t i = 0; i < 3; ++i) {
    state.w_T_rad_s[i] = rates.w_T_rad_s(static_cast<Eigen::Index>(i));
    state.v_C[i] = rates.v_C(static_cast<Eigen::Index>(i));
  }
  state.sigma_rate_rad_s = worst_sigma(rates.covariance_w_T);
  state.sigma_vel = worst_sigma(rates.covariance_v_C);
  state.rate_valid = true;
  state.velocity_valid = true;
}

}  // namespace polhode
