// Everything that this room remembers from frame to frame.
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
  double moved_rad_s = 0.0;  ///< since the one before; 0 where that is within the noise
};

/// The state of this room. Poses are kept in I, so that they stay right when the observer turns.
struct MotionEstimate {
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude at this frame
  bool observer_known = false;                         ///< it was reported; else C stands in for I
  PoseHistory recent;    ///< in I, one by one; errors of single frames, without the map's drift
  PoseHistory past;      ///< as recent, thinned: what the dynamics are fitted to
  RigidModel model;      ///< of the last fit; used while it is accepted and the poses agree
  KnownBody known_body;  ///< from a model of the target, in this T
  std::uint32_t poses_since_fit = 0;
  std::uint32_t poses_since_start =
      0;  ///< found one by one; those of an initialisation are right or wrong together
  std::uint32_t disagreements = 0;  ///< poses in succession that are not where the model has them
  std::uint32_t departures =
      0;  ///< poses in succession to which its motion from the last one before does not lead
  LastSeen last_seen;
  std::uint32_t repeats = 0;                   ///< poses since that show the same
  std::uint32_t led_to = 0;                    ///< poses so far to which its motion did lead
  std::int64_t moves_so_since_ns = INT64_MIN;  ///< it was disturbed then, the last time
};

/// May one motion be fitted to all poses since then? Not while a pose departs from it.
inline bool moves_alike_since(std::int64_t timestamp_ns, const MotionEstimate& motion) {
  return motion.departures == 0 && motion.moves_so_since_ns <= timestamp_ns;
}

/// Do the dynamics tell where the body will be? Not while a pose departs from them, or pictures
/// come that are of no moment.
inline bool dynamics_hold(const MotionEstimate& motion, const MotionOptions& options) {
  return options.mode == MotionMode::kDynamics && motion.model.accepted() &&
         motion.departures == 0 && motion.repeats == 0;
}

}  // namespace polhode
