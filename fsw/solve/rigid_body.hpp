// The motion of a rigid body by Euler's equation, and the derivatives of attitude and rate by each
// unknown.
//
// Frames: I has axes that do not rotate, T is fixed to the body. Only the shape of the inertia
// enters: its size has no influence on a free body, or under the gravity gradient.
#pragma once

#include <Eigen/Core>
#include <array>

namespace polhode {

/// Numbers of a symmetric 3x3 matrix without a trace.
inline constexpr int kShapeNumbers = 5;

/// Trace-free symmetric matrix log S in an orthonormal basis, S being the second-moment matrix of
/// the mass up to its size. Every value is a physical body; zero is one of three equal moments.
using InertiaShape = Eigen::Matrix<double, kShapeNumbers, 1>;

/// Prior 1-sigma of each number of the shape. Moments of 1:30 are 2.3 sigma.
inline constexpr double kShapeSigma = 1.5;

/// Width of the Cauchy loss of attitudes and positions: a residual of 4 sigma has half its weight.
/// It takes 2 % of the information of normal data.
inline constexpr double kPoseCauchySigma = 4.0;

/// What is known of a shape before the motion is.
struct ShapePrior {
  InertiaShape mean = InertiaShape::Zero();
  InertiaShape sigma = InertiaShape::Constant(kShapeSigma);

  [[nodiscard]] InertiaShape information() const { return sigma.cwiseAbs2().cwiseInverse(); }
};

struct Inertia {
  Eigen::Matrix3d J_T = Eigen::Matrix3d::Identity();  ///< J = I tr S - S, largest moment 1
  Eigen::Matrix3d J_inverse = Eigen::Matrix3d::Identity();
  std::array<Eigen::Matrix3d, 5> J_by_shape{};  ///< derivatives at constant scale
};

Inertia inertia_of(const InertiaShape& shape);

/// The shape of a tensor that may be unphysical: second moments are raised to at least a hundredth
/// of the largest.
InertiaShape shape_of(const Eigen::Matrix3d& J_T);

/// Matrix k of the basis of InertiaShape.
Eigen::Matrix3d shape_basis(int k);

/// A circular orbit. H is Hill's frame: x radial outward, y along track, z along the orbit normal.
struct Orbit {
  double mean_motion_rad_s = 0.0;  ///< 0: free of torque, straight relative motion
  Eigen::Matrix3d R_IH = Eigen::Matrix3d::Identity();  ///< at time 0

  [[nodiscard]] bool active() const { return mean_motion_rad_s > 0.0; }
  [[nodiscard]] Eigen::Matrix3d R_IH_at(double time_s) const;
};

struct RotationState {
  double time_s = 0.0;
  Eigen::Matrix3d R_IT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();
};

/// Unknowns of the rotation: error phi of the attitude at the reference (R_true = exp(phi) R), rate
/// at the reference, shape.
inline constexpr int kRotationUnknowns = 11;
using RotationJacobian = Eigen::Matrix<double, 3, kRotationUnknowns>;
using RotationCovariance = Eigen::Matrix<double, kRotationUnknowns, kRotationUnknowns>;

/// Derivatives by the unknowns: attitude as phi in I, rate in T.
struct RotationDerivative {
  RotationJacobian attitude_I = RotationJacobian::Zero();
  RotationJacobian rate_T = RotationJacobian::Zero();

  /// at the reference itself
  static RotationDerivative at_reference();
};

/// Rate of change of w_T. Gravity gradient where the orbit is active.
Eigen::Vector3d angular_acceleration(const Inertia& inertia,
                                     const Orbit& orbit,
                                     const RotationState& state);

/// Bound on the time of one integration: 1000 rad or 160 turns at kRotationStepAngle_rad; a fit
/// spans 32 (decision 0050).
inline constexpr int kRotationStepsMax = 20000;

/// Runge-Kutta's phase error is the step to the fourth over 120: at 0.1 rad 3e-5 rad in eight
/// turns, near the resolution of a long run (5e-5 rad of 300 frames). At 0.05 rad it is a sixteenth
/// (decision 0050).
inline constexpr double kRotationStepAngle_rad = 0.05;

/// Integrates `state` to `time_s`, earlier or later, in steps of at most kRotationStepAngle_rad:
/// fourth-order Runge-Kutta for the rate and a Magnus step for the attitude; 1e-6 rad in ten turns.
/// `derivative`, where given, is integrated along.
/// @return false when that takes over kRotationStepsMax steps or is no longer finite. The state is
/// then somewhere on the way.
bool advance(const Inertia& inertia,
             const Orbit& orbit,
             double time_s,
             RotationState& state,
             RotationDerivative* derivative);

}  // namespace polhode
