#include "motion/local_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "base/fixed_vector.hpp"

namespace polhode {
namespace {

constexpr int kTestDegree = kLocalDegreeMax + 1;  // the largest model is tested against this one
constexpr int kUnknownsMax = 3 * (kTestDegree + 1);
using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kUnknownsMax, kUnknownsMax>;
using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kUnknownsMax, 1>;
using FullNormal = Eigen::Matrix<double, kUnknownsMax, kUnknownsMax>;
using FullUnknowns = Eigen::Matrix<double, kUnknownsMax, 1>;

// Stretches grow by about sqrt(2), so that the best one is missed by at most a fifth of its length either way.
constexpr std::array<std::size_t, 17> kStretches{2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512};

// F = 5.4: the 99.9 % point of chi-square with 3 degrees of freedom (16.3) over 3.
constexpr double kBendMax = 5.4;
// A stretch stands out when its chi-square lies this many standard deviations above its expectation.
constexpr double kChi2Deviations = 3.5;
// Noise scale and bend need a few degrees of freedom to say anything: two points' worth.
constexpr int kScaleDofMin = 6;

struct Solution {
  Unknowns x;
  Normal covariance;
  double chi2 = 0.0;
  bool usable = false;
};

struct Candidate {
  LocalFit fit;
  double chi2_per_dof = 1.0;
  double bend = 0.0;  // chi-square gained by one more degree, per degree of freedom; 0 when it could not be tested
  bool tested = false;
};

/// Powers of the scaled time, or of their derivative by the scaled time.
double basis(int power, int derivative, double time) {
  if (derivative == 0) {
    return std::pow(time, power);
  }
  return power == 0 ? 0.0 : power * std::pow(time, power - 1);
}

struct Accumulated {
  FullNormal normal = FullNormal::Zero();
  FullUnknowns rhs = FullUnknowns::Zero();
};

void accumulate(const SeriesPoint& point, double scale_s, Accumulated& sum) {
  std::array<double, kTestDegree + 1> powers{};
  powers[0] = 1.0;
  for (std::size_t k = 1; k < powers.size(); ++k) {
    powers[k] = powers[k - 1] * (point.tau_s / scale_s);
  }
  const Eigen::Vector3d weighted = point.information * point.value;
  for (int j = 0; j <= kTestDegree; ++j) {
    const double pj = powers[static_cast<std::size_t>(j)];
    sum.rhs.segment<3>(3 * j) += pj * weighted;
    for (int k = 0; k <= kTestDegree; ++k) {
      sum.normal.block<3, 3>(3 * j, 3 * k) += pj * powers[static_cast<std::size_t>(k)] * point.information;
    }
  }
}

double chi2_of(std::span<const SeriesPoint> points, const Unknowns& x, double scale_s) {
  const auto degree = static_cast<int>(x.size() / 3) - 1;
  double chi2 = 0.0;
  for (const SeriesPoint& point : points) {
    const double time = point.tau_s / scale_s;
    Eigen::Vector3d model = x.segment<3>(3 * degree);
    for (int k = degree - 1; k >= 0; --k) {
      model = model * time + x.segment<3>(3 * k);
    }
    const Eigen::Vector3d residual = point.value - model;
    chi2 += residual.dot(point.information * residual);
  }
  return chi2;
}

/// Solves the leading block that belongs to `degree`, its diagonal brought to 1 first: short stretches have small powers.
Solution solve(const Accumulated& sum, int degree, std::span<const SeriesPoint> points, double scale_s) {
  Solution solution;
  const int size = 3 * (degree + 1);
  const Unknowns diagonal = sum.normal.diagonal().head(size);
  if (!(diagonal.minCoeff() > 0.0) || !diagonal.allFinite()) {
    return solution;
  }
  const Unknowns balance = diagonal.cwiseSqrt().cwiseInverse();
  const Normal balanced = balance.asDiagonal() * sum.normal.topLeftCorner(size, size) * balance.asDiagonal();
  const Eigen::LDLT<Normal> ldlt(balanced);
  // 1e-10: polynomials of degree 4 on evenly spaced points stay above 1e-6; below lie coinciding times.
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 1e-10)) {
    return solution;
  }
  const Normal identity = Normal::Identity(size, size);
  const Normal inverse = ldlt.solve(identity);
  const Unknowns balanced_rhs = balance.cwiseProduct(sum.rhs.head(size));
  solution.x = balance.cwiseProduct(Unknowns(ldlt.solve(balanced_rhs)));
  solution.covariance = balance.asDiagonal() * inverse * balance.asDiagonal();
  solution.chi2 = chi2_of(points, solution.x, scale_s);
  solution.usable = solution.x.allFinite() && solution.covariance.allFinite() && std::isfinite(solution.chi2);
  return solution;
}

LocalFit evaluate(const Solution& solution, int degree, const LocalTarget& target, double scale_s) {
  LocalFit fit;
  fit.degree = degree;
  fit.chi2 = solution.chi2;
  const double unit = target.derivative == 0 ? 1.0 : 1.0 / scale_s;
  for (int j = 0; j <= degree; ++j) {
    const double bj = unit * basis(j, target.derivative, target.tau_s / scale_s);
    fit.estimate += bj * solution.x.segment<3>(3 * j);
    fit.coefficients[static_cast<std::size_t>(j)] = solution.x.segment<3>(3 * j) / std::pow(scale_s, j);
    for (int k = 0; k <= degree; ++k) {
      const double bk = unit * basis(k, target.derivative, target.tau_s / scale_s);
      fit.covariance += bj * bk * solution.covariance.block<3, 3>(3 * j, 3 * k);
    }
  }
  fit.covariance = 0.5 * (fit.covariance + fit.covariance.transpose()).eval();
  return fit;
}

using Candidates = FixedVector<Candidate, (kStretches.size() + 1) * kLocalDegreeMax>;

/// All degrees on one stretch. A model that the data cannot test is a candidate only where there are no more data.
void try_stretch(const Accumulated& sum,
                 std::span<const SeriesPoint> points,
                 bool is_last,
                 const LocalTarget& target,
                 double scale_s,
                 Candidates& candidates) {
  const auto count = static_cast<int>(points.size());
  Solution solution = solve(sum, 1, points, scale_s);
  for (int degree = 1; degree <= kLocalDegreeMax && solution.usable; ++degree) {
    const int spare = count - degree - 1;  // points beyond an exact fit
    if (spare < 0 || (spare == 0 && !is_last)) {
      break;
    }
    Candidate candidate{.fit = evaluate(solution, degree, target, scale_s)};
    candidate.fit.points = points.size();
    candidate.fit.degrees_of_freedom = 3 * spare;
    for (const SeriesPoint& point : points) {
      candidate.fit.span_s = std::max(candidate.fit.span_s, std::abs(point.tau_s));
    }
    Solution next;
    if (spare > 0) {
      candidate.chi2_per_dof = solution.chi2 / candidate.fit.degrees_of_freedom;
      next = solve(sum, degree + 1, points, scale_s);
      candidate.tested = next.usable;
      candidate.bend = next.usable ? std::max(0.0, solution.chi2 - next.chi2) / 3.0 : 0.0;
    }
    if (!candidates.push_back(candidate)) {
      return;
    }
    solution = next;
  }
}

/// The noise level that all stretches share, at least the declared one: declared covariances are often too small.
double noise_scale(const Candidates& candidates) {
  double scale = 0.0;
  bool found = false;
  for (const Candidate& candidate : candidates) {
    if (candidate.fit.degrees_of_freedom >= kScaleDofMin) {
      scale = found ? std::min(scale, candidate.chi2_per_dof) : candidate.chi2_per_dof;
      found = true;
    }
  }
  return std::max(1.0, scale);
}

const Candidate* choose(Candidates& candidates) {
  const double scale = noise_scale(candidates);
  const Candidate* best = nullptr;
  bool best_fits = false;
  double best_variance = 0.0;
  for (Candidate& candidate : candidates) {
    const double dof = std::max(1, candidate.fit.degrees_of_freedom);
    const bool fits = candidate.bend <= kBendMax * scale &&
                      candidate.chi2_per_dof <= scale * (1.0 + kChi2Deviations * std::sqrt(2.0 / dof));
    candidate.fit.misfit = std::max({scale, candidate.chi2_per_dof, candidate.bend});
    candidate.fit.covariance *= candidate.fit.misfit;
    const double variance = candidate.fit.covariance.trace();
    if (!(variance > 0.0)) {
      continue;
    }
    if (best == nullptr || (fits && !best_fits) || (fits == best_fits && variance < best_variance)) {
      best = &candidate;
      best_fits = fits;
      best_variance = variance;
    }
  }
  return best;
}

}  // namespace

Result<LocalFit> fit_local(std::span<const SeriesPoint> points, const LocalTarget& target) {
  if (points.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  double scale_s = 0.0;
  for (const SeriesPoint& point : points) {
    scale_s = std::max(scale_s, std::abs(point.tau_s));
  }
  if (!(scale_s > 0.0) || !std::isfinite(scale_s)) {
    return ErrorCode::kDegenerate;
  }
  Accumulated sum;
  Candidates candidates;
  std::size_t stretch = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    accumulate(points[i], scale_s, sum);
    const std::size_t count = i + 1;
    while (stretch < kStretches.size() && kStretches[stretch] < count) {
      ++stretch;
    }
    const bool is_last = count == points.size();
    const bool is_stretch = stretch < kStretches.size() && kStretches[stretch] == count;
    if (count >= 2 && (is_last || is_stretch)) {
      try_stretch(sum, points.first(count), is_last, target, scale_s, candidates);
    }
  }
  const Candidate* best = choose(candidates);
  if (best == nullptr) {
    return ErrorCode::kDegenerate;
  }
  return best->fit;
}

}  // namespace polhode
