// The target as a rigid body in free motion, fitted together with its landmarks to their images.
// Where the fit is accepted, the map has no drift left (decision 0042).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "geometry/alignment.hpp"
#include "motion/rigid_model.hpp"
#include "solve/free_body_adjustment.hpp"

namespace polhode {

/// A converged map, its poses free. Changes poses and points in place where the fit is accepted.
struct JointFitInput {
  BundleProblem bundle;
  std::span<BundleObservation> observations;    ///< the bundle's; their order is changed
  std::span<const std::int64_t> timestamps_ns;  ///< by pose, in any order, none twice
  std::span<const Eigen::Matrix3d> R_IC;        ///< by pose
  double body_radius = 1.0;                     ///< unit of the poses, > 0
  MotionOptions motion;
  RigidModel previous;  ///< where accepted, the fit starts from it
  BundleOptions options;
  /// Factor on the covariance, because observations were selected by the poses. So they agree with
  /// the errors of the poses more than they should (decision 0046).
  double selection = 1.0;
};

struct BundleCopy {
  std::array<InverseDepthPose, BundleLimits::kPoses> poses;
  std::array<Eigen::Vector3d, BundleLimits::kPoints> points_T;
};

struct JointFitWorkspace {
  BundleCopy free;
  BundleCopy joint;
  std::array<std::size_t, BundleLimits::kPoses> in_order_of_time{};
  std::array<std::uint16_t, BundleLimits::kPoints> observations_of_point{};
  std::array<PoseTime, BundleLimits::kPoses> times;
  FixedVector<AttitudeSample, BundleLimits::kPoses> attitudes;
  FixedVector<PositionSample, BundleLimits::kPoses> positions;
};

/// Fits the motion of a free body to the poses, then with the points to the observations. Accepted
/// where free poses explain these no better than by following the noise (decision 0044).
/// The model's reference is the last pose; its noise level is that of the comparison.
/// @param marginal_fits  in, out: successive fits that were marginally accepted.
/// @return a model with its status; unless accepted, the bundle is unchanged.
RigidModel fit_jointly(const JointFitInput& input,
                       std::uint32_t* marginal_fits,
                       JointFitWorkspace* own);

/// The same model in other axes and another unit of T, as transformed() of a pose.
RigidModel transformed(const RigidModel& model, const Similarity& b_of_a);

}  // namespace polhode
