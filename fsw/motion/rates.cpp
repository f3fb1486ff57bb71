#include "motion/rates.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/so3.hpp"
#include "motion/local_fit.hpp"
#include "motion/residual_level.hpp"

namespace polhode {
namespace {

// Rotation vectors relative to the reference are unique below pi; 0.54 rad of margin for noise and
// bend.
constexpr double kPsiMax_rad = 2.6;
// Bodies that rotate far between frames exceed the window's angle at once. Four poses show a change
// of the rate, with one to spare.
constexpr std::size_t kPosesMin = 4;
// Largest misfit of poses that agree with a fit, as a factor on their covariances. Sigmas of single
// poses are right to a factor of two. The least window leaves a few numbers over: 99.9 % of their
// chi-square are 2.7 of each.
constexpr double kMisfitMax = 4.0 * 2.7;
// A rotation beyond three sigma counts as one.
constexpr double kRotation_sigmas2 = 9.0;

bool information_of(const Eigen::Matrix3d& covariance, Eigen::Matrix3d& information) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  if (!covariance.allFinite() || llt.info() != Eigen::Success) {
    return false;
  }
  information = llt.solve(Eigen::Matrix3d::Identity());
  return information.allFinite();
}

struct Window {
  FixedVector<RotationPoint, limits::kMotionPoses> rotation;
  FixedVector<TranslationPoint, limits::kMotionPoses> path;
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();  ///< reference attitude
};

/// Adds one pose. False when its covariance is not usable.
bool add(const PoseSample& sample, double tau_s, bool with_rotation, Window& window) {
  TranslationPoint position{
      .tau_s = tau_s, .p_CT = sample.pose.p_CT, .R_CT = sample.pose.R_CT, .information = {}};
  if (!information_of(sample.covariance.bottomRightCorner<3, 3>(), position.information) ||
      !window.path.push_back(position)) {
    return false;
  }
  if (!with_rotation) {
    return true;
  }
  RotationPoint rotation{.tau_s = tau_s,
                         .psi_rad = so3_log(window.R_CT.transpose() * sample.pose.R_CT),
                         .information = {}};
  // exp(phi) R = R_ref exp(R_ref^T phi) exp(psi): phi appears in psi as J_l(psi)^-1 R_ref^T phi.
  const Eigen::Matrix3d to_phi = window.R_CT * so3_left_jacobian(rotation.psi_rad);
  Eigen::Matrix3d information_phi;
  if (!information_of(sample.covariance.topLeftCorner<3, 3>(), information_phi)) {
    return false;
  }
  rotation.information = to_phi.transpose() * information_phi * to_phi;
  return window.rotation.push_back(rotation);
}

/// Poses around `index`, nearest in time first, at most `poses_max`. Stops at an interval that
/// gives no rate. Rotation stops where the angle gets too large.
bool collect(std::span<const PoseSample> history,
             std::size_t index,
             const MotionOptions& options,
             std::size_t poses_max,
             Window& window) {
  window.R_CT = history[index].pose.R_CT;
  std::size_t before = index;     // next candidate is before - 1
  std::size_t after = index + 1;  // next candidate
  bool rotation_open = true;
  const std::size_t first = index - std::min(index, poses_max);
  const double told_max_s = unambiguous_interval_max_s(
      history.subspan(first, std::min(history.size() - first, 2 * poses_max)));
  const auto told = [&](std::size_t a, std::size_t b) {
    return seconds_between(history[a].timestamp_ns, history[b].timestamp_ns) <= told_max_s;
  };
  std::size_t next = index;
  for (std::size_t count = 0; count < poses_max; ++count) {
    const double tau_s = seconds_between(history[index].timestamp_ns, history[next].timestamp_ns);
    const double angle_rad = rotation_angle_rad(window.R_CT, history[next].pose.R_CT);
    const double angle_max_rad = window.rotation.size() < kPosesMin
                                     ? kPsiMax_rad
                                     : std::min(kPsiMax_rad, options.window_angle_max_rad);
    rotation_open = rotation_open && angle_rad <= angle_max_rad;
    if (!add(history[next], tau_s, rotation_open, window)) {
      return false;
    }
    const bool has_before = before > 0 && told(before - 1, before);
    const bool has_after = after < history.size() && told(after - 1, after);
    if (!has_before && !has_after) {
      break;
    }
    const bool take_before =
        has_before &&
        (!has_after || history[index].timestamp_ns - history[before - 1].timestamp_ns <=
                           history[after].timestamp_ns - history[index].timestamp_ns);
    next = take_before ? --before : after++;
  }
  return true;
}

/// Rotation rate over the window: the angle of the farthest attitude over its time.
double rotation_rad_s(const Window& window) {
  double rate_rad_s = 0.0;
  double tau_max_s = 0.0;
  for (const RotationPoint& point : window.rotation) {
    if (std::abs(point.tau_s) > tau_max_s) {
      tau_max_s = std::abs(point.tau_s);
      rate_rad_s = point.psi_rad.norm() / tau_max_s;
    }
  }
  return rate_rad_s;
}

/// Mean rate from one pose to a later one, in T.
Eigen::Vector3d rate_between(const PoseSample& from, const PoseSample& to) {
  return so3_log(from.pose.R_CT.transpose() * to.pose.R_CT) /
         seconds_between(from.timestamp_ns, to.timestamp_ns);
}

/// The fastest mean rate between successive poses about `index`.
double fastest_rad_s(std::span<const PoseSample> history, std::size_t index, std::size_t poses) {
  const std::size_t first = index - std::min(index, poses);
  const std::size_t last = std::min(history.size() - 1, index + poses);
  double fastest = 0.0;
  for (std::size_t i = first; i < last; ++i) {
    fastest = std::max(fastest, rate_between(history[i], history[i + 1]).norm());
  }
  return fastest;
}

/// Covariance of the rate by its change from one interval beside `index` to the next. Poses give
/// only the mean rate of an interval: the rate at a pose may be anywhere between two means.
Eigen::Matrix3d untold_change(std::span<const PoseSample> history, std::size_t index) {
  if (history.size() < 3) {
    return Eigen::Matrix3d::Zero();
  }
  const std::size_t middle = std::clamp<std::size_t>(index, 1, history.size() - 2);
  const double change_rad_s = (rate_between(history[middle], history[middle + 1]) -
                               rate_between(history[middle - 1], history[middle]))
                                  .norm();
  const double half = 0.5 * change_rad_s;
  return half * half / 3.0 * Eigen::Matrix3d::Identity();  // evenly within plus and minus a half
}

std::size_t poses_max(const MotionOptions& options) {
  return std::min(limits::kMotionPoses,
                  static_cast<std::size_t>(std::max(2, options.window_poses_max)));
}

/// The rate at `index`, by a fit to as many poses as agree with it. A body turned by hand deviates
/// from the motion of a free one within seconds.
/// @errors Degenerate (a covariance is not usable), as fit_rotation().
Result<LocalFit> fit_rate(std::span<const PoseSample> history,
                          std::size_t index,
                          const MotionOptions& options,
                          Window& window) {
  // The rate of a body that is not free changes within a third of a free body's time. Chosen.
  constexpr double kQuicker = 3.0;
  constexpr LocalTarget kRate{.tau_s = 0.0, .derivative = 1};
  double quicker_rad_s = 0.0;
  for (std::size_t poses = poses_max(options);;) {
    window.rotation.clear();
    window.path.clear();
    if (!collect(history, index, options, poses, window)) {
      return ErrorCode::kDegenerate;
    }
    const std::size_t taken = window.rotation.size();
    Result<LocalFit> turn = fit_rotation(
        window.rotation.view(), std::max(quicker_rad_s, rotation_rad_s(window)), kRate);
    if (!turn || turn.value().misfit <= kMisfitMax || taken <= kPosesMin) {
      if (turn && quicker_rad_s > 0.0) {
        turn.value().covariance += untold_change(history, index);
      }
      return turn;
    }
    quicker_rad_s = std::max(quicker_rad_s, kQuicker * fastest_rad_s(history, index, taken));
    poses = std::max(kPosesMin, taken / 2);
  }
}

}  // namespace

double unambiguous_interval_max_s(std::span<const PoseSample> poses) {
  double fastest_rad_s = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const PoseSample& a = poses[i - 1];
    const PoseSample& b = poses[i];
    const double angle_rad = rotation_angle_rad(a.pose.R_CT, b.pose.R_CT);
    const double variance = (a.covariance + b.covariance).topLeftCorner<3, 3>().trace();
    // Else it may be noise over a short time.
    if (angle_rad * angle_rad > kRotation_sigmas2 * variance) {
      fastest_rad_s =
          std::max(fastest_rad_s, angle_rad / seconds_between(a.timestamp_ns, b.timestamp_ns));
    }
  }
  return std::numbers::pi / fastest_rad_s;
}

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
  const LocalTarget rate{.tau_s = 0.0, .derivative = 1};
  const Result<LocalFit> rotation = fit_rate(history, index, options, window);
  if (!rotation) {
    return rotation.error();
  }
  const LocalFit& turn = rotation.value();
  // The fitted attitude is R_ref exp(offset), and w_T = J_r(offset) d psi / dt there.
  const Eigen::Vector3d offset = turn.at_reference;
  const Eigen::Vector3d w_T_rad_s = so3_left_jacobian(-offset) * turn.estimate;
  const TranslationTarget path_rate{
      .at = rate, .R_CT = window.R_CT * so3_exp(offset), .w_T_rad_s = w_T_rad_s};
  const Result<LocalFit> position = fit_translation(window.path.view(), path_rate);
  if (!position) {
    return position.error();
  }
  const LocalFit& path = position.value();
  RateEstimate rates;
  rates.w_T_rad_s = w_T_rad_s;
  rates.covariance_w_T = turn.covariance;
  rates.v_C = path.estimate;
  // An error of the rate moves the origin at its offset: v contains -R (w x c).
  const Eigen::Matrix3d by_rate = path_rate.R_CT * hat(path.mass_centre_offset_T);
  rates.covariance_v_C = path.covariance + by_rate * turn.covariance * by_rate.transpose();
  rates.pose.R_CT = path_rate.R_CT;
  rates.pose.p_CT = path.at_reference;
  rates.rotation_poses = turn.points;
  rates.position_poses = path.points;
  rates.rotation_span_s = turn.span_s;
  rates.position_span_s = path.span_s;
  rates.rotation_misfit = turn.misfit;
  rates.position_misfit = path.misfit;
  return rates;
}

Result<RateEstimate> estimate_rates(std::span<const PoseSample> history,
                                    const MotionOptions& options) {
  return estimate_rates_at(history, history.empty() ? 0 : history.size() - 1, options);
}

void widen_by_drift(const PoseCovariance& drift, double turn_sigma, RateEstimate& rates) {
  const double per_s = rates.w_T_rad_s.norm() / kFaceAngle_rad;
  const Eigen::Matrix3d R_TC = rates.pose.R_CT.transpose();
  const Eigen::Vector3d sight_T = R_TC * rates.pose.p_CT.normalized();
  const Eigen::Vector3d across_rad_s = rates.w_T_rad_s - sight_T * sight_T.dot(rates.w_T_rad_s);
  rates.covariance_w_T += turn_sigma * turn_sigma * across_rad_s * across_rad_s.transpose();
  rates.covariance_w_T += per_s * per_s * R_TC * drift.topLeftCorner<3, 3>() * R_TC.transpose();
  rates.covariance_v_C += per_s * per_s * drift.bottomRightCorner<3, 3>();
}

PoseCovariance drift_until(const Pose& predicted,
                           const Pose& last,
                           const PoseCovariance& drift,
                           double turn_sigma) {
  const double turn_rad = rotation_angle_rad(last.R_CT, predicted.R_CT);
  const double sides = turn_rad / kFaceAngle_rad;
  PoseCovariance sum = (1.0 + sides * sides) * drift;
  widen_attitude(turn_rad * turn_sigma, &sum);
  return sum;
}

Result<PosePrediction> predict_pose(std::span<const PoseSample> history,
                                    std::int64_t timestamp_ns,
                                    const MotionOptions& options) {
  if (history.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  const double ahead_s = seconds_between(history.back().timestamp_ns, timestamp_ns);
  Window window;
  if (ahead_s < 0.0 || !collect(history, history.size() - 1, options, poses_max(options), window)) {
    return ErrorCode::kDegenerate;
  }
  // By the model of a free body: a shorter window follows a hand's motion and cannot be
  // extrapolated.
  const LocalTarget later{.tau_s = ahead_s, .derivative = 0};
  const Result<LocalFit> rotation =
      fit_rotation(window.rotation.view(), rotation_rad_s(window), later);
  if (!rotation) {
    return rotation.error();
  }
  const LocalFit& turn = rotation.value();
  const Eigen::Matrix3d R_CT = window.R_CT * so3_exp(turn.estimate);
  const Result<LocalFit> position =
      fit_translation(window.path.view(), {.at = later, .R_CT = R_CT});
  if (!position) {
    return position.error();
  }
  const LocalFit& path = position.value();
  const Eigen::Matrix3d to_phi = window.R_CT * so3_left_jacobian(turn.estimate);
  PosePrediction prediction;
  prediction.pose.R_CT = R_CT;
  prediction.pose.p_CT = path.estimate;
  prediction.covariance.topLeftCorner<3, 3>() = to_phi * turn.covariance * to_phi.transpose();
  // exp(phi) moves the origin by phi x (-R c).
  const Eigen::Matrix3d by_phi = hat(R_CT * path.mass_centre_offset_T);
  prediction.covariance.bottomRightCorner<3, 3>() =
      path.covariance + by_phi * prediction.covariance.topLeftCorner<3, 3>() * by_phi.transpose();
  prediction.rotation_poses = turn.points;
  prediction.position_poses = path.points;
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
