// Motion states for the tests of the bus: random but reproducible.
#pragma once

#include <cstdint>

#include "base/rng.hpp"
#include "motion/motion_state.hpp"

namespace polhode {

inline MotionState random_motion_state(std::uint64_t number) {
  Rng rng(99, number);
  MotionState state;
  state.frame = static_cast<std::uint32_t>(rng.next());
  state.timestamp_ns = static_cast<std::int64_t>(rng.next() >> 2U);
  state.mode = static_cast<Mode>(rng.below(4));
  state.pose_valid = rng.below(2) == 1;
  state.rate_valid = rng.below(2) == 1;
  state.velocity_valid = rng.below(2) == 1;
  state.scale_known = rng.below(2) == 1;
  state.scale_number = static_cast<std::uint32_t>(rng.below(16));
  if (state.pose_valid) {
    for (double& value : state.q_CT) value = 2.0 * rng.uniform() - 1.0;
    for (double& value : state.cov_pose) value = static_cast<float>(rng.normal());
    for (double& value : state.p_CT) value = 10.0 * rng.normal();
    state.sigma_att_rad = rng.uniform();
    state.sigma_pos = rng.uniform();
  }
  if (state.velocity_valid) {
    for (double& value : state.v_C) value = 0.01 * rng.normal();
    state.sigma_vel = rng.uniform();
    for (double& value : state.cov_v) value = static_cast<float>(rng.normal());
  }
  if (state.rate_valid) {
    for (double& value : state.w_T_rad_s) value = 0.1 * rng.normal();
    state.sigma_rate_rad_s = rng.uniform();
    for (double& value : state.cov_w) value = static_cast<float>(rng.normal());
  }
  state.features = static_cast<std::uint16_t>(rng.next());
  state.matches = static_cast<std::uint16_t>(rng.next());
  state.inliers = static_cast<std::uint16_t>(rng.next());
  state.landmarks = static_cast<std::uint16_t>(rng.next());
  state.keyframes = static_cast<std::uint16_t>(rng.next());
  return state;
}

}  // namespace polhode
