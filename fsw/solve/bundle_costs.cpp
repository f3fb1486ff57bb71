#include "solve/bundle_costs.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "base/index.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

template <int kRows, int kCols>
using RowMajorMap = Eigen::Map<Eigen::Matrix<double, kRows, kCols, Eigen::RowMajor>>;
using Vector6 = Eigen::Matrix<double, kPoseNumbers, 1>;

}  // namespace

ChartedPoses::ChartedPoses(std::span<const InverseDepthPose> start) : poses_(start.size()) {
  for (std::size_t k = 0; k < start.size(); ++k) {
    poses_[k].R_start = start[k].R_CT;
    poses_[k].pose = start[k];
    Eigen::Map<Eigen::Vector3d>{&poses_[k].numbers[3]} = start[k].uvs;
  }
}

void ChartedPoses::PrepareForEvaluation(bool with_derivatives, bool is_new) {
  for (ChartedPose& p : poses_) {
    const Eigen::Map<const Eigen::Vector3d> phi(p.numbers.data());
    if (is_new) {
      p.pose.R_CT = so3_exp(phi) * p.R_start;
      p.pose.uvs = Eigen::Map<const Eigen::Vector3d>(&p.numbers[3]);
    }
    if (with_derivatives) {
      p.turn_by_phi = so3_left_jacobian(phi);
    }
  }
}

bool ReprojectionCost::Evaluate(double const* const* parameters,
                                double* residuals,
                                double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p_T(parameters[1]);
  Eigen::Vector2d x;
  ReprojectionJacobians by;
  if (!reproject(pose_.pose, p_T, &x, jacobians != nullptr ? &by : nullptr)) {
    return false;
  }
  Eigen::Map<Eigen::Vector2d>{residuals} = inverse_sigma_ * (x - normalised_);
  if (jacobians == nullptr) {
    return true;
  }
  if (jacobians[0] != nullptr) {
    RowMajorMap<2, kPoseNumbers> by_pose(jacobians[0]);
    by_pose.leftCols<3>().noalias() = inverse_sigma_ * by.rotation * pose_.turn_by_phi;
    by_pose.rightCols<3>() = inverse_sigma_ * by.uvs;
  }
  if (jacobians[1] != nullptr) {
    RowMajorMap<2, 3>{jacobians[1]} = inverse_sigma_ * by.point;
  }
  return true;
}

PosePriorCost::PosePriorCost(const PosePrior& prior, const ChartedPose& pose)
    : pose_(pose), mean_(prior.mean) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kPoseNumbers, kPoseNumbers>> solver(
      prior.information);
  root_ = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
          solver.eigenvectors().transpose();
}

bool PosePriorCost::Evaluate(double const* const* /*parameters*/,
                             double* residuals,
                             double** jacobians) const {
  Vector6 deviation;
  deviation << so3_log(pose_.pose.R_CT * mean_.R_CT.transpose()), pose_.pose.uvs - mean_.uvs;
  Eigen::Map<Vector6>{residuals} = root_ * deviation;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    RowMajorMap<kPoseNumbers, kPoseNumbers> by_pose(jacobians[0]);
    by_pose.leftCols<3>() =
        root_.leftCols<3>() * so3_left_jacobian(deviation.head<3>()).inverse() * pose_.turn_by_phi;
    by_pose.rightCols<3>() = root_.rightCols<3>();
  }
  return true;
}

RateLinkCost::RateLinkCost(const RateLink& link,
                           std::span<const Eigen::Matrix3d> R_IC,
                           const ChartedPoses& poses)
    : link_(link), R_IC_(R_IC), poses_(poses) {
  mutable_parameter_block_sizes()->assign(link.poses.size(), kPoseNumbers);
  set_num_residuals(3);
}

bool RateLinkCost::Evaluate(double const* const* /*parameters*/,
                            double* residuals,
                            double** jacobians) const {
  std::array<Eigen::Matrix3d, RateLink::kPoses> change_by;  // derivatives by poses' turns in C
  std::array<Eigen::Matrix3d, RateLink::kPoses> whole_by;
  change_by.fill(Eigen::Matrix3d::Zero());
  whole_by.fill(Eigen::Matrix3d::Zero());
  Eigen::Vector3d change_I = Eigen::Vector3d::Zero();
  Eigen::Vector3d whole_I = Eigen::Vector3d::Zero();
  for (std::size_t m = 0; m + 1 < link_.poses.size(); ++m) {
    const std::size_t from = index(link_.poses[m]);
    const std::size_t to = index(link_.poses[m + 1]);
    const Eigen::Vector3d turn_I = so3_log(R_IC_[to] * poses_[to].pose.R_CT *
                                           (R_IC_[from] * poses_[from].pose.R_CT).transpose());
    const Eigen::Matrix3d by_from = -so3_left_jacobian(-turn_I).inverse() * R_IC_[from];
    const Eigen::Matrix3d by_to = so3_left_jacobian(turn_I).inverse() * R_IC_[to];
    const double factor = link_.factors_1_rad[m];
    change_I += factor * turn_I;
    whole_I += turn_I;
    change_by[m] += factor * by_from;
    change_by[m + 1] += factor * by_to;
    whole_by[m] += by_from;
    whole_by[m + 1] += by_to;
  }
  const double squared =
      whole_I.squaredNorm() + RateLink::kTurnLeast_rad * RateLink::kTurnLeast_rad;
  const double in_proportion = link_.turn_rad / std::sqrt(squared);
  const Eigen::Vector3d r = in_proportion * change_I;
  Eigen::Map<Eigen::Vector3d>{residuals} = r;
  for (std::size_t m = 0; jacobians != nullptr && m < link_.poses.size(); ++m) {
    if (jacobians[m] != nullptr) {
      RowMajorMap<3, kPoseNumbers> by_pose(jacobians[m]);
      by_pose.leftCols<3>() =
          (in_proportion * change_by[m] - r / squared * (whole_I.transpose() * whole_by[m])) *
          poses_[index(link_.poses[m])].turn_by_phi;
      by_pose.rightCols<3>().setZero();
    }
  }
  return true;
}

}  // namespace polhode
