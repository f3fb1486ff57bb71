// Attitudes of a free body with exact truth, for the tests of its fit.
#pragma once

#include <cstdint>
#include <vector>

#include "base/assert.hpp"
#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "solve/torque_free_fit.hpp"

namespace polhode::testing {

struct TumblingAttitudes {
  RotationState reference;  ///< at the first sample
  InertiaShape shape = InertiaShape::Zero();
  std::vector<AttitudeSample> samples;

  [[nodiscard]] RotationProblem problem() const { return {.samples = samples, .orbit = {}}; }
  [[nodiscard]] RotationSolution truth() const { return {.reference = reference, .shape = shape}; }
};

/// Moments 1 : 1.6 : 2.1, a sample each 2 s; by default with 6 deg of rotation between them.
inline TumblingAttitudes tumbling_attitudes(int count,
                                            double sigma_rad,
                                            double noise_sigmas,
                                            std::uint64_t seed,
                                            double rate_rad_s = 0.052) {
  Rng rng(seed, 31);
  TumblingAttitudes out;
  out.shape = shape_of(Eigen::Vector3d(1.0, 1.6, 2.1).asDiagonal());
  out.reference.R_IT = so3_exp({0.4, -0.9, 0.3});
  out.reference.w_T_rad_s = rate_rad_s * Eigen::Vector3d(0.3, 0.9, 0.4).normalized();
  const Inertia inertia = inertia_of(out.shape);
  RotationState state = out.reference;
  for (int i = 0; i < count; ++i) {
    const bool reached = advance(inertia, {}, 2.0 * i, state, nullptr);
    POLHODE_ASSERT(reached, i);
    const Eigen::Vector3d phi(rng.normal(), rng.normal(), rng.normal());
    out.samples.push_back({.time_s = 2.0 * i,
                           .R_IT = so3_exp(noise_sigmas * sigma_rad * phi) * state.R_IT,
                           .information_I = Eigen::Matrix3d::Identity() / (sigma_rad * sigma_rad)});
  }
  return out;
}

}  // namespace polhode::testing
