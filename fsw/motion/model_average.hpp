// Linear least squares whose prior and noise level are known only to an order of magnitude.
//
// Every pair of a prior from a list and a noise factor from a grid is solved. The answers are
// averaged by their evidence, how well a pair predicts the data. The covariance of the average
// contains noise, prior and the uncertainty of both.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "base/result.hpp"

namespace polhode {

/// A polynomial of degree 6 in three components (local_fit.cpp).
inline constexpr int kModelUnknownsMax = 21;
using ModelVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kModelUnknownsMax, 1>;
using ModelMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kModelUnknownsMax, kModelUnknownsMax>;
/// Three numbers as a linear function of the unknowns: answer = S^T x.
using ModelTarget = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kModelUnknownsMax, 3>;
/// Rows of the design matrix that belong to one 3-vector.
using ModelRows = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kModelUnknownsMax>;

/// Sums over the data, by their declared noise.
struct ModelData {
  ModelMatrix normal;
  ModelVector rhs;
  double square = 0.0;
  std::size_t points = 0;

  explicit ModelData(int unknowns)
      : normal(ModelMatrix::Zero(unknowns, unknowns)), rhs(ModelVector::Zero(unknowns)) {}
  void add(const ModelRows& rows, const Eigen::Vector3d& value, const Eigen::Matrix3d& information);
};

struct ModelAnswer {
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  ModelVector unknowns;  ///< averaged
  double misfit = 1.0;   ///< factor on the declared covariances, averaged, >= 1
};

/// @param priors  each the prior information of the unknowns (inverse variance about zero); the
/// same unknowns have 0, no
///                prior, in all of them. At most 16.
/// @errors Degenerate: no pair gives a regular system.
/// @cost   6 systems for each prior.
Result<ModelAnswer> average_models(const ModelData& data,
                                   std::span<const ModelVector> priors,
                                   const ModelTarget& target);

}  // namespace polhode
