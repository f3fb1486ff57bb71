#include "motion/look_ahead.hpp"

#include <algorithm>
#include <cmath>

namespace polhode {

bool begin_look_ahead(const RigidModel& model, std::int64_t timestamp_ns, LookAhead* walk) {
  walk->under_way = false;
  walk->model = model;
  if (!model.accepted() || !move_reference(timestamp_ns, walk->model)) {
    return false;
  }
  walk->state = walk->model.reference;
  walk->derivative = RotationDerivative::at_reference();
  walk->next = 0;
  walk->under_way = true;
  return true;
}

std::optional<MotionPrediction> continue_look_ahead(LookAhead* walk) {
  if (!walk->under_way) {
    return std::nullopt;
  }
  // advance() may find a step more than this on its way, where the rate grows.
  constexpr double kAngle_rad = kLookAheadStepsMax * kRotationStepAngle_rad;
  const double rate_rad_s =
      walk->state.w_T_rad_s.norm() + walk->model.orbit.mean_motion_rad_s + 1e-12;
  const double end_s = kPredictionsAhead_s[walk->next];
  const double to_s = std::min(end_s, walk->state.time_s + kAngle_rad / rate_rad_s);
  if (!advance(
          inertia_of(walk->model.shape), walk->model.orbit, to_s, walk->state, &walk->derivative)) {
    walk->under_way = false;
    return std::nullopt;
  }
  if (to_s < end_s) {
    return std::nullopt;
  }
  ++walk->next;
  walk->under_way = walk->next < kPredictionsAhead_s.size();
  return predict_at(walk->model, walk->state, walk->derivative);
}

}  // namespace polhode
