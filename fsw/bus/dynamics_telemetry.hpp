// The content of the packets of motion model and prediction.
#pragma once

#include <Eigen/Core>

#include "bus/packets.hpp"
#include "bus/shape_telemetry.hpp"
#include "motion/rates.hpp"
#include "motion/rigid_model.hpp"

namespace polhode::bus {

/// Values of the field `dynamics`.
inline constexpr std::uint8_t kDynamicsNone = 0;
inline constexpr std::uint8_t kDynamicsLocal = 1;

/// What a fit says, at its own reference time; a refused one says only why.
/// @param R_CI  takes I, in which the model is, to C. Frame is left to the caller.
ModelPacket to_packet(const RigidModel& model, const Eigen::Matrix3d& R_CI, const LengthUnit& unit);

/// A prediction by the model, as seen from axes C that keep the attitude R_CI. Time stamp and frame
/// of its making are left to the caller.
PredictionPacket to_packet(const MotionPrediction& prediction,
                           const RigidModel& model,
                           const Eigen::Matrix3d& R_CI,
                           const LengthUnit& unit);

/// A prediction by the last poses alone, in C.
PredictionPacket to_packet(const PosePrediction& prediction, const LengthUnit& unit);

}  // namespace polhode::bus
