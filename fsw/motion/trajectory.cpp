#include "motion/trajectory.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace polhode {
namespace {

/// Samples of one component of the rate, from all pairs that give one. False when a pair is not
/// usable.
bool sample_component(std::span<const PoseSample> poses,
                      double told_max_s,
                      Eigen::Index component,
                      std::span<SineSample>* samples) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const Result<PaperRate> rate = paper_rate(poses[i], poses[i + 1]);
    if (!rate) {
      return false;
    }
    if (rate.value().interval_s <= told_max_s) {
      (*samples)[count++] = {
          .time_s = seconds_between(poses[0].timestamp_ns, rate.value().timestamp_ns),
          .value = rate.value().w_T_rad_s(component),
          .sigma = std::sqrt(rate.value().covariance_w_T(component, component)),
          .interval_s = rate.value().interval_s};
    }
  }
  *samples = samples->first(count);
  return true;
}

/// Over all pairs that give a rate: time means of it and of its norm, and the mean's 1-sigma in the
/// worst direction.
struct MeanRate {
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();
  double norm_rad_s = 0.0;
  double sigma_rad_s = 0.0;
};

MeanRate mean_rate(std::span<const PoseSample> poses, double told_max_s) {
  MeanRate mean;
  double told_s = 0.0;
  double runs = 1.0;  // without a gap
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const PaperRate rate = paper_rate(poses[i], poses[i + 1]).value();
    if (rate.interval_s > told_max_s) {
      runs += 1.0;
      continue;
    }
    told_s += rate.interval_s;
    mean.w_T_rad_s += rate.interval_s * rate.w_T_rad_s;
    mean.norm_rad_s += rate.interval_s * rate.w_T_rad_s.norm();
  }
  mean.w_T_rad_s /= told_s;
  mean.norm_rad_s /= told_s;
  // Successive differences cancel except for the first and the last pose of a run.
  mean.sigma_rad_s = std::sqrt(runs) *
                     worst_sigma(poses.front().covariance.topLeftCorner<3, 3>() +
                                 poses.back().covariance.topLeftCorner<3, 3>()) /
                     told_s;
  return mean;
}

void judge_mass_centre(double body_radius, MotionModel& model) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(model.drift.covariance_c_T);
  model.mass_centre_axes_T = eigen.eigenvectors();
  for (std::size_t k = 0; k < 3; ++k) {
    const double sigma =
        std::sqrt(std::max(0.0, eigen.eigenvalues()(static_cast<Eigen::Index>(k))));
    model.mass_centre_axes[k] = observability_of(sigma, body_radius);
  }
}

}  // namespace

Observability observability_of(double sigma, double prior_sigma) {
  // A tenth of the prior's sigma: 99 % of the information is from the data.
  constexpr double kObservedMax = 0.1;
  // sqrt(1/2): half of the information is from the data, half from the prior.
  constexpr double kWeakMax = 0.7;
  if (!(sigma < kWeakMax * prior_sigma)) {
    return Observability::kUnobserved;
  }
  return sigma < kObservedMax * prior_sigma ? Observability::kObserved : Observability::kWeak;
}

Result<MotionModel> paper_model(std::span<const PoseSample> poses,
                                double body_radius,
                                std::span<SineSample> workspace) {
  if (poses.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  if (workspace.size() + 1 < poses.size()) {
    return ErrorCode::kMemoryTooSmall;
  }
  const std::span<SineSample> samples = workspace.first(poses.size() - 1);
  MotionModel model;
  model.poses = poses.size();
  model.span_s = seconds_between(poses.front().timestamp_ns, poses.back().timestamp_ns);
  const double told_max_s = unambiguous_interval_max_s(poses);
  for (Eigen::Index k = 0; k < 3; ++k) {
    std::span<SineSample> told = samples;
    if (!sample_component(poses, told_max_s, k, &told)) {
      return ErrorCode::kDegenerate;
    }
    const Result<SineFit> sine = fit_sine(told);
    if (sine) {
      model.sines[static_cast<std::size_t>(k)] = sine.value();
    }
  }
  const MeanRate mean = mean_rate(poses, told_max_s);
  model.mean_w_T_rad_s = mean.w_T_rad_s;
  model.mean_rate_rad_s = mean.norm_rad_s;
  // The norm of a noisy difference is never zero. So the mean vector, beyond 3 sigma, and the sines
  // decide whether the body rotates.
  constexpr double kRateSigmasMin = 3.0;
  bool rotates = mean.w_T_rad_s.norm() > kRateSigmasMin * mean.sigma_rad_s;
  for (const SineFit& sine : model.sines) {
    rotates = rotates || sine.observed;
  }
  model.rotation_period_s = rotates ? 2.0 * std::numbers::pi / mean.norm_rad_s : 0.0;
  const Result<DriftFit> drift = fit_drift(poses, body_radius);
  if (drift) {
    model.drift_valid = true;
    model.drift = drift.value();
    judge_mass_centre(body_radius, model);
  }
  return model;
}

}  // namespace polhode
