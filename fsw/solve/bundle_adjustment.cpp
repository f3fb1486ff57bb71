#include "solve/bundle_adjustment.hpp"

#include <ceres/ceres.h>

#include <array>
#include <memory>
#include <vector>

#include "base/assert.hpp"
#include "solve/reprojection_cost.hpp"

namespace polhode {
namespace {

bool all_finite(std::span<const PoseBlock> poses, std::span<const Eigen::Vector3d> points) {
  for (const PoseBlock& pose : poses) {
    for (const double value : pose) {
      if (!std::isfinite(value)) {
        return false;
      }
    }
  }
  for (const Eigen::Vector3d& point : points) {
    if (!point.allFinite()) {
      return false;
    }
  }
  return true;
}

ceres::Solver::Options solver_options(const BundleOptions& options, std::size_t poses) {
  ceres::Solver::Options o;
  o.max_num_iterations = options.iterations_max;
  o.num_threads = 1;
  // Past some forty moving poses the reduced camera system is sparse enough to pay for sparse
  // factorisation.
  o.linear_solver_type = poses > 40 ? ceres::SPARSE_SCHUR : ceres::DENSE_SCHUR;
  o.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  o.function_tolerance = 1e-5;
  o.gradient_tolerance = 1e-12;
  o.parameter_tolerance = 1e-9;
  o.logging_type = ceres::SILENT;
  o.minimizer_progress_to_stdout = false;
  return o;
}

class Adjustment {
 public:
  explicit Adjustment(const BundleProblem& problem)
      : problem_(problem), points_(problem.points_T.begin(), problem.points_T.end()) {
    for (const InverseDepthPose& pose : problem.poses) {
      poses_.push_back(to_block(pose));
    }
  }

  ceres::Solver::Summary solve(const BundleOptions& options) {
    ceres::Problem::Options ownership;
    ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem ceres_problem(ownership);
    ceres::CauchyLoss loss(options.cauchy_sigma);
    PoseManifold manifold;
    ceres::Solver::Options solver = solver_options(options, poses_.size());
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    add_parameters(&ceres_problem, &manifold, ordering.get());
    for (const BundleObservation& o : problem_.observations) {
      POLHODE_ASSERT(o.sigma_normalised > 0.0, o.sigma_normalised);
      ceres_problem.AddResidualBlock(new ReprojectionCost(o.normalised, o.sigma_normalised),
                                     &loss,
                                     poses_[static_cast<std::size_t>(o.pose)].data(),
                                     points_[static_cast<std::size_t>(o.point)].data());
    }
    solver.linear_solver_ordering = ordering;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &ceres_problem, &summary);
    return summary;
  }

  /// @return false, with the problem untouched, when the solution is not finite or lies behind a
  /// camera.
  bool write_back() {
    if (!all_finite(poses_, points_)) {
      return false;
    }
    for (const PoseBlock& pose : poses_) {
      if (!(pose[kPoseBlockInverseDepth] > 0.0)) {
        return false;
      }
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      problem_.poses[i] = from_block(poses_[i]);
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      problem_.points_T[i] = points_[i];
    }
    return true;
  }

 private:
  void add_parameters(ceres::Problem* ceres_problem,
                      PoseManifold* manifold,
                      ceres::ParameterBlockOrdering* ordering) {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      ceres_problem->AddParameterBlock(points_[i].data(), 3);
      ordering->AddElementToGroup(points_[i].data(), 0);
      if (problem_.point_fixed[i] != 0) {
        ceres_problem->SetParameterBlockConstant(points_[i].data());
      }
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      ceres_problem->AddParameterBlock(poses_[i].data(), kPoseBlockSize, manifold);
      ordering->AddElementToGroup(poses_[i].data(), 1);
      if (problem_.pose_fixed[i] != 0) {
        ceres_problem->SetParameterBlockConstant(poses_[i].data());
      }
    }
  }

  BundleProblem problem_;
  std::vector<PoseBlock> poses_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace

BundleReport adjust_bundle(const BundleProblem& problem, const BundleOptions& options) {
  POLHODE_ASSERT(problem.poses.size() == problem.pose_fixed.size(), problem.poses.size());
  POLHODE_ASSERT(problem.points_T.size() == problem.point_fixed.size(), problem.points_T.size());
  if (problem.observations.empty()) {
    return {};
  }
  Adjustment adjustment(problem);
  const ceres::Solver::Summary summary = adjustment.solve(options);
  BundleReport report;
  report.iterations = static_cast<int>(summary.iterations.size());
  report.cost_before = summary.initial_cost;
  report.cost_after = summary.final_cost;
  report.usable = summary.IsSolutionUsable() && adjustment.write_back();
  return report;
}

}  // namespace polhode
