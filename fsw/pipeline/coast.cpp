#include "pipeline/coast.hpp"

#include "map/track.hpp"
#include "motion/stamp_doubt.hpp"
#include "pipeline/state.hpp"
#include "pipeline/track.hpp"

namespace polhode {

std::optional<PosePrediction> coasted_pose(std::int64_t timestamp_ns, const Component::State& s) {
  const MotionEstimate& motion = s.motion;
  if (motion.recent.empty() || timestamp_ns <= motion.recent.back().timestamp_ns ||
      motion.departures > 0 || doubt_of_stamps(motion.recent.view()).contradicted) {
    return std::nullopt;
  }
  Result<PosePrediction> predicted = predict_by_motion(
      motion, s.mapping.drift, s.configuration.parameters.motion, timestamp_ns, motion.R_IC);
  if (!predicted) {
    return std::nullopt;
  }
  PosePrediction& coasted = predicted.value();
  coasted.covariance += covariance(s.mapping.drift);
  const bool known =
      worst_sigma(coasted.covariance.topLeftCorner<3, 3>()) < kPredictionSigmaMost_rad &&
      coasted.pose.p_CT.z() > 0.0;
  return known ? std::optional(coasted) : std::nullopt;
}

void coast(std::int64_t timestamp_ns, Component::State* s) {
  if (!has_target(s->mode)) {
    return;
  }
  drop_reference(&s->mapping);
  if (coasted_pose(timestamp_ns, *s)) {
    change_mode(ModeEvent::kPosePredicted, &s->mode);
  } else if (s->mode.now == Mode::kCoasting) {
    lose_target(s);
  }
}

}  // namespace polhode
