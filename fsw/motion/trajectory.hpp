// Motion over a whole run, from all its poses: the model of paper mode at the end of a run.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "base/result.hpp"
#include "motion/options.hpp"
#include "motion/paper.hpp"
#include "motion/pose_history.hpp"
#include "motion/rates.hpp"

namespace polhode {

/// Whether the data determine a quantity: by its sigma in parts of the prior's.
enum class Observability : std::uint8_t { kUnobserved = 0, kWeak = 1, kObserved = 2 };
[[nodiscard]] Observability observability_of(double sigma, double prior_sigma);

struct MotionModel {
  std::size_t poses = 0;
  double span_s = 0.0;
  Eigen::Vector3d mean_w_T_rad_s = Eigen::Vector3d::Zero();  ///< time mean of the body rates
  double mean_rate_rad_s = 0.0;                              ///< time mean of their norm
  double rotation_period_s =
      0.0;  ///< of one rotation at the mean rate; 0 when the body rests within 3 sigma
  std::array<SineFit, 3> sines{};  ///< of w_T's components; meaningful where observed
  bool drift_valid = false;
  DriftFit drift;                                   ///< velocity and centre of mass
  std::array<Observability, 3> mass_centre_axes{};  ///< along the columns of mass_centre_axes_T
  Eigen::Matrix3d mass_centre_axes_T =
      Eigen::Matrix3d::Identity();  ///< principal axes of covariance_c_T, best first
};

/// Paper mode over a run: rates from pairs of poses, a sine through each component, velocity with
/// the centre of mass.
/// @param poses        time strictly increasing; at most kSineSamplesMax + 1.
/// @param body_radius  half the body's largest dimension, unit of the poses: the centre of mass
/// lies within.
/// @param workspace    at least poses.size() - 1 samples.
/// @errors TooFewObservations (under 2 poses), Degenerate (times or covariances not usable),
/// MemoryTooSmall.
///         What cannot be determined is marked so in the model (sines not observed, drift not
///         valid).
Result<MotionModel> paper_model(std::span<const PoseSample> poses,
                                double body_radius,
                                std::span<SineSample> workspace);

}  // namespace polhode
