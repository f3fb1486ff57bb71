// The motion of a rigid body by Euler's equation, and what attitude and rate at a later time owe to
// each unknown.
//
// Frames: I axes that do not turn, T fixed to the body. Inertia enters by its shape alone: its size
// has no influence on a body that is free or moved by the gravity gradient.
#pragma once

#include <Eigen/Core>
#include <array>

namespace polhode {

/// Trace-free symmetric matrix log S in an orthonormal basis, S being the second-moment matrix of
/// the mass up to its size. Every value is a physical body; zero is one of three equal moments.
using InertiaShape = Eigen::Matrix<double, 5, 1>;

struct Inertia {
  Eigen::Matrix3d J_T = Eigen::Matrix3d::Identity();  ///< J = I tr S - S, largest moment 1
  Eigen::Matrix3d J_inverse = Eigen::Matrix3d::Identity();
  std::array<Eigen::Matrix3d, 5> J_by_shape{};  ///< derivatives, of the same scale held fixed
};

Inertia inertia_of(const InertiaShape& shape);

/// The shape of a tensor that need not be physical: second moments under a hundredth of the largest
/// are lifted to that.
InertiaShape shape_of(const Eigen::Matrix3d& J_T);

/// A matrix of the basis that InertiaShape counts in.
Eigen::Matrix3d shape_basis(int k);

/// A circular orbit. H is Hill's frame: x radial outward, y along track, z along the orbit normal.
struct Orbit {
  double mean_motion_rad_s = 0.0;  ///< 0: free of torque, straight relative motion
  Eigen::Matrix3d R_IH = Eigen::Matrix3d::Identity();  ///< at time 0

  [[nodiscard]] bool active() const { return mean_motion_rad_s > 0.0; }
  [[nodiscard]] Eigen::Matrix3d R_IH_at(double time_s) const;
};

struct TurningState {
  double time_s = 0.0;
  Eigen::Matrix3d R_IT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();
};

/// Unknowns of the turning: error phi of the attitude at the reference (R_true = exp(phi) R), rate
/// at the reference, shape.
inline constexpr int kTurningUnknowns = 11;
using TurningMatrix = Eigen::Matrix<double, 3, kTurningUnknowns>;
using TurningCovariance = Eigen::Matrix<double, kTurningUnknowns, kTurningUnknowns>;

/// Derivatives by the unknowns: attitude as phi in I, rate in T.
struct TurningDerivative {
  TurningMatrix attitude_I = TurningMatrix::Zero();
  TurningMatrix rate_T = TurningMatrix::Zero();

  /// At the reference itself.
  static TurningDerivative at_reference();
};

/// Rate of change of w_T. Gravity gradient where the orbit is active.
Eigen::Vector3d angular_acceleration(const Inertia& inertia,
                                     const Orbit& orbit,
                                     const TurningState& state);

inline constexpr int kTurningStepsMax = 20000;

/// Runge-Kutta's phase lags by the step to the fourth over 120: at 0.1 rad by 3e-5 rad in eight
/// turns, near what a long run can tell (5e-5 rad of 300 frames); at 0.05 rad by a sixteenth of
/// that.
inline constexpr double kTurningStepAngle_rad = 0.05;

/// Moves `state` to `time_s`, earlier or later, in steps that turn by at most
/// kTurningStepAngle_rad: fourth-order Runge-Kutta for the rate and a Magnus step for the attitude;
/// 1e-6 rad in ten turns. `derivative`, where given, is moved along.
/// @return false, with the state somewhere on the way, when that takes over kTurningStepsMax steps
/// or leaves the numbers.
bool advance(const Inertia& inertia,
             const Orbit& orbit,
             double time_s,
             TurningState& state,
             TurningDerivative* derivative);

}  // namespace polhode
