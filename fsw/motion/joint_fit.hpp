// The target as a rigid body in free motion, fitted with its landmarks to their images: where that
// holds, the map has no drift left.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "geometry/alignment.hpp"
#include "motion/rigid_model.hpp"
#include "solve/free_body_adjustment.hpp"

namespace polhode {

/// A map at rest, its poses free. Poses and points are changed in place where the fit is accepted.
struct JointFitInput {
  BundleProblem bundle;
  std::span<BundleObservation> observations;    ///< the bundle's; their order is changed
  std::span<const std::int64_t> timestamps_ns;  ///< by pose, in any order, none twice
  std::span<const Eigen::Matrix3d> R_IC;        ///< by pose
  double body_radius = 1.0;                     ///< unit of the poses, > 0
  MotionOptions motion;
  RigidModel previous;  ///< where accepted, the fit starts from it
  BundleOptions options;
  /// What the covariance is to be multiplied by, as the sightings were chosen by where the poses
  /// have them and so agree with the poses' errors more than they should.
  double selection = 1.0;
};

struct BundleCopy {
  std::array<InverseDepthPose, BundleWorkspace::kPoses> poses;
  std::array<Eigen::Vector3d, BundleWorkspace::kPoints> points_T;
};

struct JointFitWorkspace {
  BundleCopy free;
  BundleCopy joint;
  std::array<std::uint8_t, BundleWorkspace::kPoses> none_held{};
  std::array<std::uint8_t, BundleWorkspace::kPoses> all_held{};
  std::array<std::size_t, BundleWorkspace::kPoses> in_order_of_time{};
  std::array<std::uint16_t, BundleWorkspace::kPoints> sightings_of_point{};
  std::array<PoseTime, BundleWorkspace::kPoses> times;
  FixedVector<AttitudeSample, BundleWorkspace::kPoses> attitudes;
  FixedVector<PositionSample, BundleWorkspace::kPoses> positions;
  FreeBodyWorkspace free_body;
};

/// A free body's motion is fitted to the poses, then with the points to the sightings. It is
/// accepted where it explains them as well as free poses do, up to what free poses gain by
/// following the noise.
/// @param doubts  in, out: how often it was believed on sufferance since it last was without.
/// The answer's reference is the last pose; its noise is that found by the comparison.
/// @return a model that says by its status whether it was accepted; else the bundle is as it was.
RigidModel fit_jointly(const JointFitInput& input,
                       std::uint32_t* doubts,
                       BundleWorkspace* workspace,
                       JointFitWorkspace* own);

/// The same model in other axes and another unit of T, as transformed() of a pose.
RigidModel transformed(const RigidModel& model, const Similarity& b_of_a);

}  // namespace polhode
