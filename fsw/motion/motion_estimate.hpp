// The state of the motion from frame to frame.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "motion/options.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {

/// The last pose checked, as the camera saw it: a repeat is detected by comparing the next one.
struct LastSeen {
  bool any = false;
  PoseSample pose_C;
  double moved_rad_s = 0.0;  ///< rate since the pose before; 0 where it is within the noise
};

/// The motion's state. Poses are kept in I, so they remain valid when the observer rotates.
struct MotionEstimate {
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude at this frame
  bool observer_known = false;                         ///< it was reported; else C is used as I
  PoseHistory recent;    ///< in I, one by one; errors of single frames, without the map's drift
  PoseHistory past;      ///< as recent, thinned: input of the fit of the dynamics
  RigidModel model;      ///< of the last fit; used while accepted and consistent with the poses
  KnownBody known_body;  ///< from a model of the target, in this T
  std::uint32_t poses_since_fit = 0;
  std::uint32_t poses_since_start =
      0;  ///< measured one by one; those of an initialisation share their errors
  std::uint32_t disagreements = 0;  ///< successive poses that differ from the model's pose
  std::uint32_t departures =
      0;  ///< successive poses inconsistent with the motion predicted from the last consistent one
  LastSeen last_seen;
  std::uint32_t repeats = 0;                   ///< successive repeats of that pose
  std::uint32_t led_to = 0;                    ///< poses so far that its motion has predicted
  std::int64_t moves_so_since_ns = INT64_MIN;  ///< time of the last disturbance
};

/// Can one motion be fitted to all poses since that time? Not while a pose is inconsistent with it.
inline bool moves_alike_since(std::int64_t timestamp_ns, const MotionEstimate& motion) {
  return motion.departures == 0 && motion.moves_so_since_ns <= timestamp_ns;
}

/// Are the dynamics valid for prediction? Not while a pose is inconsistent with them, or repeats.
inline bool dynamics_hold(const MotionEstimate& motion, const MotionOptions& options) {
  return options.mode == MotionMode::kDynamics && motion.model.accepted() &&
         motion.departures == 0 && motion.repeats == 0;
}

}  // namespace polhode
