// The same adjustment by Ceres with automatic derivatives: what our own is held against.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "solve/bundle_adjustment.hpp"

namespace polhode::reference {

struct Projection {
  Eigen::Vector2d normalised;
  double sigma = 1.0;

  template <typename T>
  bool operator()(const T* q_CT, const T* uvs, const T* p_T, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(q_CT);
    const Eigen::Matrix<T, 3, 1> turned = q * Eigen::Map<const Eigen::Matrix<T, 3, 1>>(p_T);
    const T depth = T(1.0) + uvs[2] * turned.z();
    residual[0] = ((uvs[2] * turned.x() + uvs[0]) / depth - normalised.x()) / sigma;
    residual[1] = ((uvs[2] * turned.y() + uvs[1]) / depth - normalised.y()) / sigma;
    return depth > T(0.0);
  }
};

/// @return final cost, half the robust sum of squares.
inline double adjust_by_ceres(const BundleProblem& p, double cauchy_sigma, int iterations_max) {
  std::vector<Eigen::Quaterniond> q;
  for (const InverseDepthPose& pose : p.poses) {
    q.emplace_back(pose.R_CT);
  }
  ceres::Problem problem;
  for (const BundleObservation& o : p.observations) {
    const auto k = static_cast<std::size_t>(o.pose);
    const auto i = static_cast<std::size_t>(o.point);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Projection, 2, 4, 3, 3>(new Projection{
                                 .normalised = o.normalised, .sigma = o.sigma_normalised}),
                             new ceres::CauchyLoss(cauchy_sigma),
                             q[k].coeffs().data(),
                             p.poses[k].uvs.data(),
                             p.points_T[i].data());
  }
  for (std::size_t k = 0; k < q.size(); ++k) {
    problem.SetManifold(q[k].coeffs().data(), new ceres::EigenQuaternionManifold);
    if (p.pose_fixed[k] != 0) {
      problem.SetParameterBlockConstant(q[k].coeffs().data());
      problem.SetParameterBlockConstant(p.poses[k].uvs.data());
    }
  }
  for (std::size_t i = 0; i < p.points_T.size(); ++i) {
    if (p.point_fixed[i] != 0) {
      problem.SetParameterBlockConstant(p.points_T[i].data());
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = iterations_max;
  options.function_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t k = 0; k < q.size(); ++k) {
    p.poses[k].R_CT = q[k].normalized().toRotationMatrix();
  }
  return summary.final_cost;
}

}  // namespace polhode::reference
