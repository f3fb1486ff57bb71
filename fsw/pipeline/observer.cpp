#include "pipeline/observer.hpp"

#include "geometry/so3.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

std::optional<Eigen::Quaterniond> reported_attitude(const StepInput& input,
                                                    const ServicerAttitude& servicer) {
  if (input.q_IC) {
    const std::array<double, 4>& q = *input.q_IC;
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  if (!servicer.known) {
    return std::nullopt;
  }
  const double since_s =
      1e-9 * static_cast<double>(input.frame.timestamp_ns - servicer.timestamp_ns);
  return servicer.q_IC * Eigen::Quaterniond(so3_exp(since_s * servicer.w_C_rad_s));
}

}  // namespace

void set_observer(const StepInput& input, Component::State* s) {
  const std::optional<Eigen::Matrix3d> turn =
      take_observer(reported_attitude(input, s->bus.servicer), &s->motion);
  if (!turn) {
    return;
  }
  for (Keyframe& keyframe : s->mapping.map.keyframes) {
    keyframe.R_IC = *turn * keyframe.R_IC;
  }
  for (CollectedFrame& frame : s->initialisation.tracks.frames) {
    frame.R_IC = *turn * frame.R_IC;
  }
  invalidate_fits(&s->jobs);
}

}  // namespace polhode
