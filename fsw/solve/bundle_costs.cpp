#include "solve/bundle_costs.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

template <int kRows, int kCols>
using RowMajor = Eigen::Matrix<double, kRows, kCols, Eigen::RowMajor>;
template <int kRows, int kCols>
using RowMajorMap = Eigen::Map<RowMajor<kRows, kCols>>;
using Numbers = Eigen::Map<const Eigen::Vector3d>;
using Rotation = Eigen::Map<const Eigen::Matrix3d>;
constexpr int kRotationNumbers = 9;

/// Derivative of R's nine numbers by phi of exp(phi) R.
Eigen::Matrix<double, kRotationNumbers, 3> rotation_by_turn(const Eigen::Matrix3d& R) {
  Eigen::Matrix<double, kRotationNumbers, 3> by_turn;
  for (int column = 0; column < 3; ++column) {
    by_turn.middleRows<3>(3 * column) = -hat(R.col(column));
  }
  return by_turn;
}

/// Derivative of phi by R's nine numbers. As R's columns are orthonormal, by_turn' by_turn = 2.
Eigen::Matrix<double, 3, kRotationNumbers> turn_by_rotation(const Eigen::Matrix3d& R) {
  return 0.5 * rotation_by_turn(R).transpose();
}

}  // namespace

PoseNumbers numbers_of(const InverseDepthPose& pose) {
  PoseNumbers numbers;
  std::copy_n(pose.R_CT.data(), kRotationNumbers, numbers.begin());
  std::copy_n(pose.uvs.data(), 3, numbers.begin() + kRotationNumbers);
  return numbers;
}

InverseDepthPose pose_of(const double* numbers) {
  return {.R_CT = Rotation(numbers), .uvs = Numbers(numbers + kRotationNumbers)};
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  InverseDepthPose pose = pose_of(x);
  pose.R_CT = so3_exp(Numbers(delta)) * pose.R_CT;
  pose.uvs += Numbers(delta + 3);
  const PoseNumbers moved = numbers_of(pose);
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;  // where a pose comes to lie behind its camera, costs refuse it
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  RowMajorMap<kPoseNumbers, kPoseFreedom> J(jacobian);
  J.setZero();
  J.topLeftCorner<kRotationNumbers, 3>() = rotation_by_turn(Rotation(x));
  J.bottomRightCorner<3, 3>().setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const InverseDepthPose to = pose_of(y);
  const InverseDepthPose from = pose_of(x);
  Eigen::Map<Eigen::Vector3d>{y_minus_x} = so3_log(to.R_CT * from.R_CT.transpose());
  Eigen::Map<Eigen::Vector3d>{y_minus_x + 3} = to.uvs - from.uvs;
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  RowMajorMap<kPoseFreedom, kPoseNumbers> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, kRotationNumbers>() = turn_by_rotation(Rotation(x));
  J.bottomRightCorner<3, 3>().setIdentity();
  return true;
}

bool ReprojectionCost::Evaluate(double const* const* parameters,
                                double* residuals,
                                double** jacobians) const {
  const InverseDepthPose pose = pose_of(parameters[0]);
  const Numbers p_T(parameters[1]);
  Eigen::Vector2d x;
  ReprojectionJacobians by;
  if (!reproject(pose, p_T, &x, jacobians != nullptr ? &by : nullptr)) {
    return false;
  }
  const double inverse_sigma = 1.0 / o_.sigma_normalised;
  Eigen::Map<Eigen::Vector2d>{residuals} = inverse_sigma * (x - o_.normalised);
  if (jacobians == nullptr) {
    return true;
  }
  if (jacobians[0] != nullptr) {
    // q = R p is moved by R's columns, each with its part of p, as p is by R: derivative by p is
    // that by q times R.
    RowMajorMap<2, kPoseNumbers> by_pose(jacobians[0]);
    const Eigen::Matrix<double, 2, 3> by_q = inverse_sigma * by.point * pose.R_CT.transpose();
    for (int column = 0; column < 3; ++column) {
      by_pose.middleCols<3>(3 * column) = p_T[column] * by_q;
    }
    by_pose.rightCols<3>() = inverse_sigma * by.uvs;
  }
  if (jacobians[1] != nullptr) {
    RowMajorMap<2, 3>{jacobians[1]} = inverse_sigma * by.point;
  }
  return true;
}

PosePriorCost::PosePriorCost(const PosePrior& prior) : mean_(prior.mean) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(prior.information);
  root_ = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
          solver.eigenvectors().transpose();
}

bool PosePriorCost::Evaluate(double const* const* parameters,
                             double* residuals,
                             double** jacobians) const {
  const InverseDepthPose pose = pose_of(parameters[0]);
  Eigen::Matrix<double, 6, 1> departure;
  departure << so3_log(pose.R_CT * mean_.R_CT.transpose()), pose.uvs - mean_.uvs;
  Eigen::Map<Eigen::Matrix<double, 6, 1>>{residuals} = root_ * departure;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Matrix<double, kPoseFreedom, kPoseNumbers> by_numbers;
    by_numbers.setZero();
    by_numbers.topLeftCorner<3, kRotationNumbers>() =
        so3_left_jacobian(departure.head<3>()).inverse() * turn_by_rotation(pose.R_CT);
    by_numbers.bottomRightCorner<3, 3>().setIdentity();
    RowMajorMap<kPoseFreedom, kPoseNumbers>{jacobians[0]} = root_ * by_numbers;
  }
  return true;
}

}  // namespace polhode
