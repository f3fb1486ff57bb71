// What a bundle costs, as Ceres's cost functions with their derivatives written out.
#pragma once

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Numbers of a pose as Ceres holds it: R_CT column by column, then (u, v, s). A step of it has six:
/// phi of R = exp(phi) R_CT, then those of uvs.
inline constexpr int kPoseNumbers = 12;
inline constexpr int kPoseFreedom = 6;
using PoseNumbers = std::array<double, kPoseNumbers>;

PoseNumbers numbers_of(const InverseDepthPose& pose);
InverseDepthPose pose_of(const double* numbers);

/// Rotations turn from the left.
class PoseManifold final : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return kPoseNumbers; }
  [[nodiscard]] int TangentSize() const override { return kPoseFreedom; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// Distance of a point's image from its observation, in sigma, by (pose, p_T). No value where the
/// point lies behind the camera.
class ReprojectionCost final : public ceres::SizedCostFunction<2, kPoseNumbers, 3> {
 public:
  explicit ReprojectionCost(const BundleObservation& observation) : o_(observation) {}
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  BundleObservation o_;
};

/// Departure of a pose from its prior, (phi, uvs), in sigma.
class PosePriorCost final : public ceres::SizedCostFunction<kPoseFreedom, kPoseNumbers> {
 public:
  explicit PosePriorCost(const PosePrior& prior);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  InverseDepthPose mean_;
  Eigen::Matrix<double, 6, 6> root_;  ///< root' root is the information
};

}  // namespace polhode
