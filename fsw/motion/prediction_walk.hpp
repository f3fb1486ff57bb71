// Predictions minutes ahead, by bounded work a frame: one integration from now to the farthest
// time, gone in parts, that tells of the times on its way.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "motion/rigid_model.hpp"

namespace polhode {

/// Times ahead that are told, s.
inline constexpr std::array<double, 9> kPredictionsAhead_s{
    10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0};

/// Steps of the integration in one frame. One with its derivatives takes about a microsecond.
inline constexpr int kWalkStepsMax = 500;

struct PredictionWalk {
  bool under_way = false;
  RigidModel model;  ///< as it was at the beginning
  TurningState state;
  TurningDerivative derivative;
  std::size_t next = 0;  ///< of kPredictionsAhead_s
};

/// From the model's own time. @return false, with nothing under way, when the model is not accepted
/// or does not reach that time.
bool begin_walk(const RigidModel& model, std::int64_t timestamp_ns, PredictionWalk* walk);

/// Goes on by at most kWalkStepsMax steps, to the next time at most. It ends with the last one.
/// @return the prediction for a time that has been reached.
std::optional<MotionPrediction> walk_on(PredictionWalk* walk);

}  // namespace polhode
