#include "bus/publish_motion.hpp"

#include <cmath>

#include "bus/bus_state.hpp"
#include "bus/dynamics_telemetry.hpp"
#include "bus/narrow.hpp"
#include "motion/estimator.hpp"

namespace polhode::bus {
namespace {

bool dynamics_accepted(const View& view) {
  return view.motion_options->mode == MotionMode::kDynamics && view.estimate->model.accepted();
}

/// Copies the rate of the motion packet.
void put_local_rate(const MotionState& motion, const PoseHistory& poses, ModelPacket* packet) {
  packet->poses = static_cast<std::uint32_t>(poses.size());
  if (!poses.empty()) {
    packet->span_s =
        static_cast<float>(seconds_between(poses[0].timestamp_ns, poses.back().timestamp_ns));
  }
  if (motion.rate_valid) {
    packet->dynamics = kDynamicsLocal;
    packet->flags |= model_layout::kFlagRate;
    packet->w_T_rad_s = motion.w_T_rad_s;
    packet->cov_w = narrowed(motion.cov_w);
  }
}

void send_local_prediction(const View& view, BusState* bus) {
  const MotionState& motion = *view.motion;
  const std::int64_t ahead_ns =
      motion.timestamp_ns + std::llround(1e9 * kPredictionsAhead_s.front());
  Result<PosePrediction> predicted = predict_by_motion(
      *view.estimate, *view.drift, *view.motion_options, ahead_ns, view.estimate->R_IC);
  if (!predicted) {
    return;
  }
  predicted.value().covariance += drift_until(
      predicted.value().pose, *view.pose, covariance(*view.drift), turn_sigma(*view.drift));
  widen(view.camera.error, predicted.value().pose.p_CT.norm(), &predicted.value().covariance);
  PredictionPacket packet = to_packet(predicted.value(), view.unit);
  packet.timestamp_ns = motion.timestamp_ns;
  packet.predicted_timestamp_ns = ahead_ns;
  packet.frame = motion.frame;
  append(packet, *view.options, &bus->stream);
}

}  // namespace

std::uint8_t dynamics_in_force(const View& view) {
  if (dynamics_accepted(view)) {
    return dynamics_of(view.estimate->model);
  }
  return view.motion->rate_valid ? kDynamicsLocal : kDynamicsNone;
}

void send_model(const View& view, BusState* bus) {
  const MotionState& motion = *view.motion;
  RigidModel model = view.estimate->model;
  const bool reached = dynamics_hold(*view.estimate, *view.motion_options) &&
                       move_reference(motion.timestamp_ns, model);
  if (!reached && model.accepted()) {
    model = {};  // its time is out of reach, or the dynamics are not valid now
  }
  ModelPacket packet = to_packet(model, view.estimate->R_IC.transpose(), view.unit);
  packet.timestamp_ns = motion.timestamp_ns;
  packet.frame = motion.frame;
  if (!model.accepted()) {
    put_local_rate(motion, view.estimate->recent, &packet);
  }
  append(packet, *view.options, &bus->stream);
}

void send_prediction(const View& view, bool due, BusState* bus) {
  const MotionState& motion = *view.motion;
  PredictionsUnderWay& ahead = bus->predictions;
  ahead.walk.under_way =
      ahead.walk.under_way && dynamics_hold(*view.estimate, *view.motion_options);
  if (due && !ahead.walk.under_way) {
    const bool begun = dynamics_hold(*view.estimate, *view.motion_options) &&
                       begin_look_ahead(view.estimate->model, motion.timestamp_ns, &ahead.walk);
    if (!begun && is_measured(motion)) {
      send_local_prediction(view, bus);
    }
    ahead.timestamp_ns = motion.timestamp_ns;
    ahead.frame = motion.frame;
    ahead.R_IC = view.estimate->R_IC;
  }
  std::optional<MotionPrediction> reached = continue_look_ahead(&ahead.walk);
  if (!reached) {
    return;
  }
  reached->covariance += turned(ahead.R_IC, view.drift->reanchoring);
  widen(view.camera.error, reached->pose.p_CT.norm(), &reached->covariance);
  PredictionPacket packet =
      to_packet(*reached, ahead.walk.model, ahead.R_IC.transpose(), view.unit);
  packet.timestamp_ns = ahead.timestamp_ns;
  packet.frame = ahead.frame;
  append(packet, *view.options, &bus->stream);
}

}  // namespace polhode::bus
