// Fills the packets of the motion model and its predictions.
#pragma once

#include <Eigen/Core>

#include "bus/packets.hpp"
#include "bus/shape_telemetry.hpp"
#include "motion/point_state.hpp"
#include "motion/rates.hpp"
#include "motion/rigid_model.hpp"

namespace polhode::bus {

/// Values of the field `dynamics` (config/bus/telemetry.toml).
inline constexpr std::uint8_t kDynamicsNone = 0;
inline constexpr std::uint8_t kDynamicsLocal = 1;
inline constexpr std::uint8_t kDynamicsTorqueFree = 2;
inline constexpr std::uint8_t kDynamicsOrbit = 3;  ///< the last

// Chosen: 30 deg. A worse attitude is of no use, and there a first-order covariance is no longer
// valid: the sine of 0.5 rad is 4 % less than the angle.
inline constexpr double kAttitudeSigmaMax_rad = 0.5;
// Chosen, of the distance, for the same two reasons.
inline constexpr double kPositionSigmaMax = 0.5;

/// What an accepted fit assumes, as a value of that field.
std::uint8_t dynamics_of(const RigidModel& model);

/// A fit at its own reference time; of a refused one, only the reason. The caller sets the frame.
/// @param R_CI  takes I, in which the model is, to C.
ModelPacket to_packet(const RigidModel& model, const Eigen::Matrix3d& R_CI, const LengthUnit& unit);

/// A prediction by the model, in axes C that keep the attitude R_CI. The caller sets time stamp and
/// frame.
PredictionPacket to_packet(const MotionPrediction& prediction,
                           const RigidModel& model,
                           const Eigen::Matrix3d& R_CI,
                           const LengthUnit& unit);

/// The predicted position of a point. The caller sets the number of the request and that of T.
PointPacket to_packet(const PointState& point);

/// A prediction from the last poses alone, in C.
PredictionPacket to_packet(const PosePrediction& prediction, const LengthUnit& unit);

}  // namespace polhode::bus
