// Rotations: exponential and logarithm on SO(3), left Jacobian, nearest rotation.
#pragma once

#include <Eigen/Core>

namespace polhode {

/// Cross-product matrix: hat(a) * b = a x b.
Eigen::Matrix3d hat(const Eigen::Vector3d& a);

/// Rotation matrix of the rotation vector `phi_rad` (Rodrigues), exact to rounding for all angles.
Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi_rad);

/// Rotation vector of R, norm in [0, pi]. At exactly pi the axis has either sign.
Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);

/// J_l with exp(phi + d) ~ exp(J_l(phi) d) exp(phi) for small d.
Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi_rad);

/// The rotation nearest to M in the Frobenius norm.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M);

/// Angle of R_a^T R_b, in [0, pi].
double rotation_angle_rad(const Eigen::Matrix3d& R_a, const Eigen::Matrix3d& R_b);

}  // namespace polhode
