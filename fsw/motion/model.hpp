// The target as a rigid body in free motion: the result of a fit. Axes: as in rigid_model.hpp.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "solve/mass_centre_fit.hpp"
#include "solve/torque_free_fit.hpp"

namespace polhode {

enum class ModelStatus : std::uint8_t {
  kAccepted = 0,
  kTooFewPoses = 1,        ///< under kModelPosesMin
  kNoFit = 2,              ///< no initial estimate converged to a solution over all poses
  kResidualsTooLarge = 3,  ///< chi-square: poses or their times are not those of a free rigid body
};

/// How the residuals compare with the declared covariance of the poses.
struct ResidualLevel {
  double chi2_per_dof = 0.0;  ///< by the declared covariance, outliers left out
  /// Found variance over the declared one, shrunk towards 1 where data are few. Of a joint fit: the
  /// factor on the covariance, for drift that the motion has followed as well.
  double scale2 = 1.0;
  double correlation = 1.0;  ///< poses with the information of one independent pose, >= 1
  std::size_t outliers = 0;
  std::size_t outliers_at_end = 0;  ///< among the newest poses, in succession
};

/// All unknowns: those of the rotation, then those of the translation.
inline constexpr int kModelUnknownsAll = kRotationUnknowns + kTranslationUnknowns;
using ModelCovariance = Eigen::Matrix<double, kModelUnknownsAll, kModelUnknownsAll>;

struct RigidModel {
  ModelStatus status = ModelStatus::kTooFewPoses;
  bool translation_known = false;  ///< the translation is fitted, too
  bool of_map = false;             ///< of a joint fit: its poses are those of the map
  std::int64_t reference_ns = 0;
  RotationState reference;  ///< its time is 0
  InertiaShape shape = InertiaShape::Zero();
  TranslationVector path = TranslationVector::Zero();
  ModelCovariance covariance = ModelCovariance::Zero();  ///< of noise found, and its correlation
  double mass_centre_sigma = 1.0;                        ///< prior of the mass centre's place
  Orbit orbit;                                           ///< its time 0 is the reference
  ResidualLevel attitude;
  ResidualLevel position;
  std::size_t poses = 0;
  double span_s = 0.0;

  [[nodiscard]] bool accepted() const { return status == ModelStatus::kAccepted; }
};

/// 24 numbers for the 11 unknowns of the rotation. Chosen: about twice as many.
inline constexpr std::size_t kModelPosesMin = 8;
/// Prior of each number of the shape, in logarithms of second moments. Two moments then differ by a
/// factor of exp(1.5 sqrt(2)) = 8 at one sigma. It keeps short spans in bounds
/// (decision 0049).
inline constexpr double kModelShapeSigma = 1.5;

}  // namespace polhode
