#include "pipeline/motion_telemetry.hpp"

#include <cmath>

#include "bus/dynamics_telemetry.hpp"
#include "bus/narrow.hpp"

namespace polhode {
namespace {

bool dynamics_hold(const Component::State& s) {
  return s.parameters.motion.mode == MotionMode::kDynamics && s.motion.model.accepted();
}

/// The rate that the motion packet has.
void put_local_rate(const MotionState& motion, const PoseHistory& poses, bus::ModelPacket* packet) {
  packet->poses = static_cast<std::uint32_t>(poses.size());
  if (!poses.empty()) {
    packet->span_s =
        static_cast<float>(seconds_between(poses[0].timestamp_ns, poses.back().timestamp_ns));
  }
  if (motion.rate_valid) {
    packet->dynamics = bus::kDynamicsLocal;
    packet->flags |= bus::model_layout::kFlagRate;
    packet->w_T_rad_s = motion.w_T_rad_s;
    packet->cov_w = bus::narrowed(motion.cov_w);
  }
}

void send_local_prediction(const MotionState& motion, Component::State* s) {
  const std::int64_t ahead_ns =
      motion.timestamp_ns + std::llround(1e9 * kPredictionsAhead_s.front());
  const Result<PosePrediction> predicted = predict_by_motion(*s, ahead_ns, s->motion.R_IC);
  if (!predicted) {
    return;
  }
  bus::PredictionPacket packet = bus::to_packet(predicted.value(), length_unit(s->scale));
  packet.timestamp_ns = motion.timestamp_ns;
  packet.predicted_timestamp_ns = ahead_ns;
  packet.frame = motion.frame;
  append(packet, s->parameters.bus, &s->bus.stream);
}

}  // namespace

void send_model(const MotionState& motion, Component::State* s) {
  RigidModel model = s->motion.model;
  const bool reached = dynamics_hold(*s) && move_reference(motion.timestamp_ns, model);
  if (!reached && model.accepted()) {
    model = {};  // its time is out of reach, or the mode asks for pairs of poses
  }
  bus::ModelPacket packet =
      bus::to_packet(model, s->motion.R_IC.transpose(), length_unit(s->scale));
  packet.timestamp_ns = motion.timestamp_ns;
  packet.frame = motion.frame;
  if (!model.accepted()) {
    put_local_rate(motion, s->motion.recent, &packet);
  }
  append(packet, s->parameters.bus, &s->bus.stream);
}

void send_prediction(const MotionState& motion, bool due, Component::State* s) {
  AheadNow& ahead = s->ahead;
  ahead.walk.under_way = ahead.walk.under_way && dynamics_hold(*s);
  if (due && !ahead.walk.under_way) {
    const bool begun =
        dynamics_hold(*s) && begin_walk(s->motion.model, motion.timestamp_ns, &ahead.walk);
    if (!begun && motion.pose_valid) {
      send_local_prediction(motion, s);
    }
    ahead.timestamp_ns = motion.timestamp_ns;
    ahead.frame = motion.frame;
    ahead.R_IC = s->motion.R_IC;
  }
  const std::optional<MotionPrediction> reached = walk_on(&ahead.walk);
  if (!reached) {
    return;
  }
  bus::PredictionPacket packet = bus::to_packet(
      *reached, ahead.walk.model, ahead.R_IC.transpose(), length_unit(s->scale));
  packet.timestamp_ns = ahead.timestamp_ns;
  packet.frame = ahead.frame;
  append(packet, s->parameters.bus, &s->bus.stream);
}

}  // namespace polhode
