#include "motion/model_average.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/fixed_vector.hpp"

namespace polhode {
namespace {

// Declared variance may be too small by up to 64 (sigma by 8): map errors shared by all poses, and
// accepted outliers. Chosen; powers of two, coarser at the end.
constexpr std::array<double, 6> kNoiseFactors{1.0, 2.0, 4.0, 8.0, 16.0, 64.0};
// Prior of a noise factor: each doubling is half as likely. Else few points would be explained by
// noise and a smooth motion.
constexpr double kNoiseFactorPower = -1.0;
// A chi-square this many standard deviations above its expectation widens the covariance. One-sided
// normal: 1 in 4300 by chance.
constexpr double kChi2Deviations = 3.5;
// Capacity; 9 are used (local_fit.cpp).
constexpr std::size_t kPriorsMax = 16;
// Least pivot of the balanced system. Below, times nearly coincide and value and rate are not
// separated; the other unknowns have a prior.
constexpr double kPivotMin = 1e-11;

struct Solution {
  double noise_factor = 1.0;
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  ModelVector x;
  double log_evidence = 0.0;
  double chi2 = 0.0;  // of the data, by the declared noise
};

using Solutions = FixedVector<Solution, kPriorsMax * kNoiseFactors.size()>;

/// Log of the product of those that are not zero.
double log_product(const ModelVector& information) {
  double sum = 0.0;
  for (const double value : information) {
    sum += value > 0.0 ? std::log(value) : 0.0;
  }
  return sum;
}

/// One prior, one noise factor. False when the system is singular.
bool solve(const ModelData& data,
           const ModelVector& prior,
           const ModelTarget& target,
           Solution& solution) {
  ModelMatrix H = data.normal / solution.noise_factor;
  H.diagonal() += prior;
  const ModelVector balance = H.diagonal().cwiseSqrt().cwiseInverse();
  if (!balance.allFinite()) {
    return false;
  }
  const ModelMatrix balanced = balance.asDiagonal() * H * balance.asDiagonal();
  const Eigen::LDLT<ModelMatrix> ldlt(balanced);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > kPivotMin)) {
    return false;
  }
  const ModelVector rhs = balance.cwiseProduct(data.rhs) / solution.noise_factor;
  solution.x = balance.cwiseProduct(ModelVector(ldlt.solve(rhs)));
  const ModelTarget scaled = balance.asDiagonal() * target;
  solution.estimate = target.transpose() * solution.x;
  solution.covariance = scaled.transpose() * ModelTarget(ldlt.solve(scaled));
  solution.chi2 = std::max(
      0.0, data.square - 2.0 * solution.x.dot(data.rhs) + solution.x.dot(data.normal * solution.x));
  const double log_det_H = ldlt.vectorD().array().log().sum() - 2.0 * balance.array().log().sum();
  const double log_noise = std::log(solution.noise_factor);
  solution.log_evidence =
      0.5 * (log_product(prior) - log_det_H - 3.0 * static_cast<double>(data.points) * log_noise -
             solution.chi2 / solution.noise_factor - solution.x.cwiseAbs2().dot(prior)) +
      kNoiseFactorPower * log_noise;
  return std::isfinite(solution.log_evidence) && solution.estimate.allFinite() &&
         solution.covariance.allFinite();
}

ModelAnswer average(const Solutions& solutions, std::size_t points) {
  double log_evidence_max = solutions[0].log_evidence;
  for (const Solution& solution : solutions) {
    log_evidence_max = std::max(log_evidence_max, solution.log_evidence);
  }
  ModelAnswer answer;
  answer.unknowns = ModelVector::Zero(solutions[0].x.size());
  answer.misfit = 0.0;
  double total = 0.0;
  double chi2 = 0.0;  // by the noise of each solution
  for (const Solution& solution : solutions) {
    const double weight = std::exp(solution.log_evidence - log_evidence_max);
    total += weight;
    answer.estimate += weight * solution.estimate;
    answer.unknowns += weight * solution.x;
    answer.misfit += weight * solution.noise_factor;
    chi2 += weight * solution.chi2 / solution.noise_factor;
  }
  answer.estimate /= total;
  answer.unknowns /= total;
  answer.misfit /= total;
  for (const Solution& solution : solutions) {
    const double weight = std::exp(solution.log_evidence - log_evidence_max) / total;
    const Eigen::Vector3d apart = solution.estimate - answer.estimate;
    answer.covariance += weight * (solution.covariance + apart * apart.transpose());
  }
  const double freedom = 3.0 * static_cast<double>(points);
  const double excess = chi2 / total / freedom;
  if (excess > 1.0 + kChi2Deviations * std::sqrt(2.0 / freedom)) {
    answer.misfit *= excess;
    answer.covariance *= excess;
  }
  answer.covariance = 0.5 * (answer.covariance + answer.covariance.transpose()).eval();
  return answer;
}

}  // namespace

void ModelData::add(const ModelRows& rows,
                    const Eigen::Vector3d& value,
                    const Eigen::Matrix3d& information) {
  const ModelRows weighted = information * rows;
  normal.noalias() += rows.transpose() * weighted;
  rhs.noalias() += weighted.transpose() * value;
  square += value.dot(information * value);
  ++points;
}

Result<ModelAnswer> average_models(const ModelData& data,
                                   std::span<const ModelVector> priors,
                                   const ModelTarget& target) {
  POLHODE_ASSERT(priors.size() <= kPriorsMax, priors.size());
  Solutions solutions;
  for (const ModelVector& prior : priors) {
    for (const double noise_factor : kNoiseFactors) {
      Solution solution;
      solution.noise_factor = noise_factor;
      if (solve(data, prior, target, solution)) {
        POLHODE_ASSERT(solutions.push_back(solution), solutions.size());
      }
    }
  }
  if (solutions.empty()) {
    return ErrorCode::kDegenerate;
  }
  return average(solutions, data.points);
}

}  // namespace polhode
