// Predictions minutes ahead, by bounded work a frame: one integration from now to the farthest
// time, computed in parts, with a prediction at each time on the way.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "motion/rigid_model.hpp"

namespace polhode {

/// Times of the predictions after now, s.
inline constexpr std::array<double, 9> kPredictionsAhead_s{
    10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0};

/// Steps of the integration in one frame. One with its derivatives takes about a microsecond.
inline constexpr int kLookAheadStepsMax = 500;

struct LookAhead {
  bool under_way = false;
  RigidModel model;  ///< as it was at the beginning
  RotationState state;
  RotationDerivative derivative;
  std::size_t next = 0;  ///< index into kPredictionsAhead_s
};

/// From the model's own time. @return false, with nothing under way, when the model is not accepted
/// or does not reach that time.
bool begin_look_ahead(const RigidModel& model, std::int64_t timestamp_ns, LookAhead* walk);

/// Continues by at most kLookAheadStepsMax steps, and no further than the next prediction time.
/// Ends with the last of these times.
/// @return the prediction for a time that has been reached.
std::optional<MotionPrediction> continue_look_ahead(LookAhead* walk);

}  // namespace polhode
