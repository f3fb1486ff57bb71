// Ceres's cost functions of a bundle, with analytic derivatives.
#pragma once

#include <ceres/evaluation_callback.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "solve/bundle_problem.hpp"

namespace polhode {

/// A pose as Ceres's parameters: phi of R = exp(phi) R_start, then uvs. A chart about the initial
/// pose: with a manifold each Jacobian would be multiplied by the manifold's (decision 0041).
inline constexpr int kPoseNumbers = 6;

struct ChartedPose {
  std::array<double, kPoseNumbers> numbers{};  ///< Ceres's parameter block
  Eigen::Matrix3d R_start = Eigen::Matrix3d::Identity();
  InverseDepthPose pose;                                      ///< at these numbers,
  Eigen::Matrix3d turn_by_phi = Eigen::Matrix3d::Identity();  ///< and the left Jacobian there
};

/// Poses of a bundle at Ceres's present parameters: computed once an evaluation.
class ChartedPoses final : public ceres::EvaluationCallback {
 public:
  explicit ChartedPoses(std::span<const InverseDepthPose> start);
  void PrepareForEvaluation(bool with_derivatives, bool is_new) override;

  [[nodiscard]] double* numbers(std::size_t k) { return poses_[k].numbers.data(); }
  [[nodiscard]] const ChartedPose& operator[](std::size_t k) const { return poses_[k]; }

 private:
  std::vector<ChartedPose> poses_;
};

/// Distance of a point's projection from its observation, in sigma, by (pose, p_T). No value where
/// the point lies behind the camera.
class ReprojectionCost final : public ceres::SizedCostFunction<2, kPoseNumbers, 3> {
 public:
  ReprojectionCost(const BundleObservation& observation, const ChartedPose& pose)
      : pose_(pose),
        normalised_(observation.normalised),
        inverse_sigma_(1.0 / observation.sigma_normalised) {}
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const ChartedPose& pose_;
  Eigen::Vector2d normalised_;
  double inverse_sigma_;
};

/// Deviation of a pose from its prior, (phi, uvs), in sigma.
class PosePriorCost final : public ceres::SizedCostFunction<kPoseNumbers, kPoseNumbers> {
 public:
  PosePriorCost(const PosePrior& prior, const ChartedPose& pose);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const ChartedPose& pose_;
  InverseDepthPose mean_;
  Eigen::Matrix<double, kPoseNumbers, kPoseNumbers> root_;  ///< root' root is the information
};

/// Change of the rate of rotation over the poses of a link, in sigma, by their (phi, uvs).
class RateLinkCost final : public ceres::CostFunction {
 public:
  /// @param R_IC  the camera's attitude at each pose of the bundle; it and `poses` outlive the
  /// cost.
  RateLinkCost(const RateLink& link,
               std::span<const Eigen::Matrix3d> R_IC,
               const ChartedPoses& poses);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  RateLink link_;
  std::span<const Eigen::Matrix3d> R_IC_;
  const ChartedPoses& poses_;
};

}  // namespace polhode
