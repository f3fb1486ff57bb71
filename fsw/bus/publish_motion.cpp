#include "pipeline/motion_telemetry.hpp"

#include <cmath>

#include "bus/dynamics_telemetry.hpp"
#include "bus/narrow.hpp"
#include "geometry/so3.hpp"
#include "motion/residual_level.hpp"

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

/// What the map's drift adds to a pose that the last ones predict: its own now, and by the turn
/// until then what it does to their rates.
PoseCovariance drift_until(const Pose& predicted, const Component::State& s) {
  const PoseCovariance now = covariance(s.drift);
  const Pose& last = s.localised.absolute.pose;
  const double turn_rad = rotation_angle_rad(last.R_CT, predicted.R_CT);
  const double sides = turn_rad / kSideAngle_rad;
  PoseCovariance sum = (1.0 + sides * sides) * now;
  const double by_rate_rad = turn_rad * turn_sigma(s.drift);
  sum.topLeftCorner<3, 3>().diagonal().array() += by_rate_rad * by_rate_rad;
  return sum;
}

void send_local_prediction(const MotionState& motion, Component::State* s) {
  const std::int64_t ahead_ns =
      motion.timestamp_ns + std::llround(1e9 * kPredictionsAhead_s.front());
  Result<PosePrediction> predicted =
      predict_by_motion(s->motion, s->drift, s->parameters.motion, ahead_ns, s->motion.R_IC);
  if (!predicted) {
    return;
  }
  predicted.value().covariance += drift_until(predicted.value().pose, *s);
  bus::PredictionPacket packet = bus::to_packet(predicted.value(), length_unit(*s));
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
  bus::ModelPacket packet = bus::to_packet(model, s->motion.R_IC.transpose(), length_unit(*s));
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
  std::optional<MotionPrediction> reached = walk_on(&ahead.walk);
  if (!reached) {
    return;
  }
  reached->covariance += turned(ahead.R_IC, s->drift.bridge);
  bus::PredictionPacket packet =
      bus::to_packet(*reached, ahead.walk.model, ahead.R_IC.transpose(), length_unit(*s));
  packet.timestamp_ns = ahead.timestamp_ns;
  packet.frame = ahead.frame;
  append(packet, s->parameters.bus, &s->bus.stream);
}

}  // namespace polhode
