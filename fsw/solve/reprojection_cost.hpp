// The reprojection residual as Ceres sees it. Private to this folder.
#pragma once

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "geometry/reprojection.hpp"
#include "geometry/so3.hpp"

namespace polhode {

/// A pose in Ceres' memory: quaternion x, y, z, w, then u, v, s of InverseDepthPose.
inline constexpr int kPoseBlockSize = 7;
inline constexpr std::size_t kPoseBlockInverseDepth = 6;
using PoseBlock = std::array<double, kPoseBlockSize>;

inline PoseBlock to_block(const InverseDepthPose& pose) {
  const Eigen::Quaterniond q(pose.R_CT);
  return {q.x(), q.y(), q.z(), q.w(), pose.uvs.x(), pose.uvs.y(), pose.uvs.z()};
}

inline InverseDepthPose from_block(const double* block) {
  const Eigen::Quaterniond q(block[3], block[0], block[1], block[2]);
  return {.R_CT = q.normalized().toRotationMatrix(), .uvs = {block[4], block[5], block[6]}};
}
inline InverseDepthPose from_block(const PoseBlock& block) { return from_block(block.data()); }

/// Left perturbation R <- exp(phi) R and plain addition on (u, v, s). The cost functions below
/// write their derivatives by the tangent into the first six of the seven ambient columns, so the
/// lift back to the tangent is a plain selection: this saves the product with the 4x3 quaternion
/// Jacobian in every residual.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseBlockSize; }
  int TangentSize() const override { return 6; }

  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Eigen::Vector3d phi(delta[0], delta[1], delta[2]);
    const double angle = phi.norm();
    const Eigen::Quaterniond step = angle > 0.0
                                        ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, phi / angle))
                                        : Eigen::Quaterniond::Identity();
    const Eigen::Quaterniond q = (step * Eigen::Quaterniond(x[3], x[0], x[1], x[2])).normalized();
    x_plus_delta[0] = q.x();
    x_plus_delta[1] = q.y();
    x_plus_delta[2] = q.z();
    x_plus_delta[3] = q.w();
    for (int i = 0; i < 3; ++i) {
      x_plus_delta[4 + i] = x[4 + i] + delta[3 + i];
    }
    return true;
  }

  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseBlockSize, 6, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRows<6>().setIdentity();
    return true;
  }

  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Eigen::Matrix3d R_y = from_block(y).R_CT;
    const Eigen::Matrix3d R_x = from_block(x).R_CT;
    const Eigen::Vector3d phi = so3_log(R_y * R_x.transpose());
    for (int i = 0; i < 3; ++i) {
      y_minus_x[i] = phi[i];
      y_minus_x[3 + i] = y[4 + i] - x[4 + i];
    }
    return true;
  }

  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, kPoseBlockSize, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.leftCols<6>().setIdentity();
    return true;
  }
};

/// Residual (projection - measurement) / sigma of one landmark in one frame.
class ReprojectionCost final : public ceres::SizedCostFunction<2, kPoseBlockSize, 3> {
 public:
  ReprojectionCost(const Eigen::Vector2d& normalised, double sigma_normalised)
      : measured_(normalised), weight_(1.0 / sigma_normalised) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const InverseDepthPose pose = from_block(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> p_T(parameters[1]);
    Eigen::Vector2d projected;
    ReprojectionJacobians J;
    if (!reproject(pose, p_T, &projected, &J)) {
      return false;
    }
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = weight_ * (projected - measured_);
    if (jacobians == nullptr) {
      return true;
    }
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor>> by_pose(jacobians[0]);
      by_pose.leftCols<3>() = weight_ * J.rotation;
      by_pose.middleCols<3>(3) = weight_ * J.uvs;
      by_pose.col(6).setZero();
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> by_point(jacobians[1]);
      by_point = weight_ * J.point;
    }
    return true;
  }

 private:
  Eigen::Vector2d measured_;
  double weight_;
};

}  // namespace polhode
