#include "solve/bundle_adjustment.hpp"

#include <ceres/loss_function.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <vector>

#include "base/assert.hpp"
#include "base/index.hpp"
#include "solve/bundle_costs.hpp"
#include "solve/bundle_part.hpp"
#include "solve/ceres_solver.hpp"
#include "solve/settle_points.hpp"

namespace polhode {
namespace {

// Width of the loss of priors, in sigmas: 1.4 % of normal errors in six numbers are larger
// (chi-square).
constexpr double kPriorCauchySigma = 4.0;
// Width of the loss of rate links: 1 % of normal errors in three numbers lie beyond (chi-square). A
// contact lies tens of sigmas beyond.
constexpr double kLinkCauchySigma = 3.4;
// Ceres eliminates its groups in order.
constexpr int kPointGroup = 0;
constexpr int kPoseGroup = 1;

bool fits(const BundleProblem& problem) {
  return problem.poses.size() <= BundleLimits::kPoses &&
         problem.points_T.size() <= BundleLimits::kPoints &&
         problem.observations.size() <= BundleLimits::kObservations;
}

/// Builds Ceres's problem in the order of the poses, points and observations, so that the same
/// problem gives the same bytes.
class CeresBundle {
 public:
  CeresBundle(const BundleProblem& problem, double cauchy_sigma)
      : p_(problem),
        poses_(problem.poses),
        loss_(cauchy_sigma),
        prior_loss_(kPriorCauchySigma),
        link_loss_(kLinkCauchySigma),
        ceres_(problem_options(&poses_)) {
    add_blocks();
    add_residuals();
  }

  ceres::Solver::Summary solve(int iterations_max) {
    ceres::Solver::Options options = solver_options(iterations_max);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t i = 0; i < p_.points_T.size(); ++i) {
      options.linear_solver_ordering->AddElementToGroup(p_.points_T[i].data(), kPointGroup);
    }
    for (std::size_t k = 0; k < p_.poses.size(); ++k) {
      options.linear_solver_ordering->AddElementToGroup(poses_.numbers(k), kPoseGroup);
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    return summary;
  }

  void take_poses() {
    poses_.PrepareForEvaluation(false, true);  // Ceres may have rejected the last trial
    for (std::size_t k = 0; k < p_.poses.size(); ++k) {
      p_.poses[k] = poses_[k].pose;
    }
  }

 private:
  void add_blocks() {
    for (std::size_t k = 0; k < p_.poses.size(); ++k) {
      ceres_.AddParameterBlock(poses_.numbers(k), kPoseNumbers);
      if (p_.pose_fixed[k] != 0) {
        ceres_.SetParameterBlockConstant(poses_.numbers(k));
      }
    }
  }

  void add_residuals() {
    const PointObservations by_point(p_.observations, p_.points_T.size());
    for (std::size_t i = 0; i < p_.points_T.size(); ++i) {
      ceres_.AddParameterBlock(p_.points_T[i].data(), 3);
      if (p_.point_fixed[i] != 0) {
        ceres_.SetParameterBlockConstant(p_.points_T[i].data());
      }
      for (const BundleObservation& o : by_point.of(i)) {
        costs_.emplace_back(o, poses_[index(o.pose)]);
        ceres_.AddResidualBlock(
            &costs_.back(), &loss_, poses_.numbers(index(o.pose)), p_.points_T[i].data());
      }
    }
    for (const PosePrior& prior : p_.priors) {
      priors_.emplace_back(prior, poses_[index(prior.pose)]);
      ceres_.AddResidualBlock(&priors_.back(), &prior_loss_, poses_.numbers(index(prior.pose)));
    }
    for (const RateLink& link : p_.links) {
      links_.emplace_back(link, p_.R_IC, poses_);
      std::vector<double*> blocks;
      for (const std::int32_t pose : link.poses) {
        blocks.push_back(poses_.numbers(index(pose)));
      }
      ceres_.AddResidualBlock(&links_.back(), &link_loss_, blocks);
    }
  }

  const BundleProblem& p_;
  ChartedPoses poses_;
  std::deque<ReprojectionCost> costs_;
  std::deque<PosePriorCost> priors_;
  std::deque<RateLinkCost> links_;
  ceres::CauchyLoss loss_;
  ceres::CauchyLoss prior_loss_;
  ceres::CauchyLoss link_loss_;
  ceres::Problem ceres_;
};

BundleReport solve(const BundleProblem& problem, const BundleOptions& options) {
  CeresBundle bundle(problem, options.cauchy_sigma);
  const BundleReport report = report_of(bundle.solve(options.iterations_max));
  if (report.usable) {
    bundle.take_poses();
  }
  return report;
}

}  // namespace

BundleReport adjust_bundle(const BundleProblem& problem, const BundleOptions& options) {
  POLHODE_ASSERT(problem.poses.size() == problem.pose_fixed.size(), problem.poses.size());
  POLHODE_ASSERT(problem.points_T.size() == problem.point_fixed.size(), problem.points_T.size());
  POLHODE_ASSERT(fits(problem), problem.observations.size());
  if (problem.observations.empty()) {
    return {};
  }
  const BundlePart part(problem, options.observations_max);
  const BundleReport report = solve(part.problem(), options);
  if (report.usable) {
    part.put_back(options.cauchy_sigma);
  }
  return report;
}

}  // namespace polhode
