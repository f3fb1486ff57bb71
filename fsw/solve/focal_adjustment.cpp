#include "solve/focal_adjustment.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <vector>

#include "solve/bundle_costs.hpp"
#include "solve/bundle_part.hpp"
#include "solve/ceres_solver.hpp"

namespace polhode {
namespace {

// Ceres eliminates its groups in order.
constexpr int kFocalPointGroup = 0;
constexpr int kFocalPoseGroup = 1;

/// As ReprojectionCost, in a picture of another focal length: by (pose, p_T, log of the factor).
class FocalCost final : public ceres::SizedCostFunction<2, kPoseNumbers, 3, 1> {
 public:
  FocalCost(const BundleObservation& observation, const ChartedPose& pose)
      : projection_({.pose = observation.pose,
                     .point = observation.point,
                     .normalised = Eigen::Vector2d::Zero(),
                     .sigma_normalised = observation.sigma_normalised},
                    pose),
        measured_(observation.normalised / observation.sigma_normalised) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    if (!projection_.Evaluate(parameters, residuals, jacobians)) {
      return false;
    }
    const double factor = std::exp(parameters[2][0]);
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual *= factor;
    if (jacobians != nullptr) {
      scale(jacobians[0], 2 * kPoseNumbers, factor);
      scale(jacobians[1], 2 * 3, factor);
      if (jacobians[2] != nullptr) {
        Eigen::Map<Eigen::Vector2d>{jacobians[2]} = residual;
      }
    }
    residual -= measured_;
    return true;
  }

 private:
  static void scale(double* jacobian, int count, double factor) {
    if (jacobian != nullptr) {
      Eigen::Map<Eigen::VectorXd>{jacobian, count} *= factor;
    }
  }
  ReprojectionCost projection_;  ///< of a measured (0, 0): the projection itself, in sigma
  Eigen::Vector2d measured_;
};

/// Copies of a problem's poses and points in Ceres's terms, with one focal length. Solved several
/// times, each time from where it ended.
class FocalBundle {
 public:
  FocalBundle(const BundleProblem& problem, double cauchy_sigma)
      : pose_count_(problem.poses.size()),
        poses_(problem.poses),
        points_(problem.points_T.begin(), problem.points_T.end()),
        loss_(cauchy_sigma),
        ceres_(problem_options(&poses_)) {
    ceres_.AddParameterBlock(&log_factor_, 1);
    for (std::size_t k = 0; k < problem.poses.size(); ++k) {
      ceres_.AddParameterBlock(poses_.numbers(k), kPoseNumbers);
      if (problem.pose_fixed[k] != 0) {
        ceres_.SetParameterBlockConstant(poses_.numbers(k));
      }
    }
    for (Eigen::Vector3d& point : points_) {
      ceres_.AddParameterBlock(point.data(), 3);
    }
    for (const BundleObservation& o : problem.observations) {
      const auto k = static_cast<std::size_t>(o.pose);
      costs_.emplace_back(o, poses_[k]);
      ceres_.AddResidualBlock(&costs_.back(),
                              &loss_,
                              poses_.numbers(k),
                              points_[static_cast<std::size_t>(o.point)].data(),
                              &log_factor_);
    }
  }

  /// @param hold  keep the focal length as it is
  BundleReport solve(bool hold, int iterations_max) {
    if (hold) {
      ceres_.SetParameterBlockConstant(&log_factor_);
    } else {
      ceres_.SetParameterBlockVariable(&log_factor_);
    }
    ceres::Solver::Options options = solver_options(iterations_max);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    // A step that gains less is not taken. A focal length settles along a weak direction, and a
    // gain of one in the cost is 1.4 sigma.
    options.function_tolerance = 1e-7;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (Eigen::Vector3d& point : points_) {
      options.linear_solver_ordering->AddElementToGroup(point.data(), kFocalPointGroup);
    }
    for (std::size_t k = 0; k < pose_count_; ++k) {
      options.linear_solver_ordering->AddElementToGroup(poses_.numbers(k), kFocalPoseGroup);
    }
    options.linear_solver_ordering->AddElementToGroup(&log_factor_, kFocalPoseGroup);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    return report_of(summary);
  }

  double& log_factor() { return log_factor_; }

 private:
  std::size_t pose_count_;
  ChartedPoses poses_;
  std::vector<Eigen::Vector3d> points_;
  std::deque<FocalCost> costs_;
  ceres::CauchyLoss loss_;
  double log_factor_ = 0.0;
  ceres::Problem ceres_;
};

// Off by less than this nothing is refuted. Measured: right intrinsics are off by up to 1.2 % where
// the sigma is under 2 % (decision 0083).
constexpr double kPartMin = 0.08;
constexpr double kSigmas = 4.0;  // a right one fails one test in 16,000

/// From how the least cost rises a step aside.
double sigma_of(double step, double cost_best, double cost_aside, std::size_t observations) {
  // Errors along one track are alike: decision 0085 has two to three times the residual.
  constexpr double kAlike = 3.0;
  // A misfit that the sigmas do not explain counts, too: half a robust square each way at least.
  const double level = std::max(1.0, cost_best / static_cast<double>(observations));
  const double rise = std::max(cost_aside - cost_best, 1e-12);
  return kAlike * std::sqrt(level) * step / std::sqrt(2.0 * rise);
}

}  // namespace

FocalReport adjust_focal(const BundleProblem& problem, const BundleOptions& options) {
  constexpr double kAside = 0.02;  // of the focal length; some sigma where it is known at all
  const BundlePart part(problem, options.observations_max);
  const std::size_t observations = part.problem().observations.size();
  if (observations == 0) {
    return {};
  }
  FocalBundle bundle(part.problem(), options.cauchy_sigma);
  const BundleReport as_given = bundle.solve(true, options.iterations_max);
  const BundleReport best = bundle.solve(false, options.iterations_max);
  const double log_factor = bundle.log_factor();
  bundle.log_factor() += log_factor > 0.0 ? -kAside : kAside;  // towards the given one
  const BundleReport aside = bundle.solve(true, options.iterations_max);
  if (!as_given.usable || !best.usable || !aside.usable || !std::isfinite(log_factor)) {
    return {};
  }
  return {.usable = true,
          .factor = std::exp(log_factor),
          .relative_sigma = sigma_of(kAside, best.cost_after, aside.cost_after, observations),
          .cost_as_given = as_given.cost_after,
          .cost_at_factor = best.cost_after,
          .observations = observations};
}

bool refutes_focal(const FocalReport& found) {
  const double off = std::abs(std::log(found.factor));
  return found.usable && off > kPartMin && off > kSigmas * found.relative_sigma;
}

bool bears_focal_out(const FocalReport& found) {
  return found.usable && kSigmas * found.relative_sigma < kPartMin && !refutes_focal(found);
}

double part_off(const FocalReport& found) {
  return refutes_focal(found) ? std::abs(std::log(found.factor)) : 0.0;
}

}  // namespace polhode
