#include "solve/affine_factorisation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <span>

#include "base/assert.hpp"
#include "base/consensus.hpp"
#include "base/median.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

using Axes = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Tracks of a sample: four determine the subspace about their centroid, the fifth averages noise.
constexpr int kSample = 5;
// With 65 % inliers one draw in nine holds inliers only: 40 draws miss with under 1 % probability.
constexpr int kDraws = 40;
// Rounds of choosing inliers and fitting them. Chosen.
constexpr int kRounds = 3;
// Gate in standard deviations of a coordinate. 0.3 % of normal coordinates lie beyond, fewer of the
// means over a track.
constexpr double kToleranceSigma = 3.0;
// Least inliers. Four determine the subspace; the others show its noise. Chosen.
constexpr int kInliersMin = 6;
// "AFFS": the random stream of this sampler.
constexpr std::uint64_t kStream = 0x41464653ULL;
// Least singular value, as a part of the largest: keeps a flat shape's axes finite.
constexpr double kSingularMin = 1e-9;
// Least eigenvalue of Q, as a part of the largest: a direction that noise made imaginary gets a
// seventh of the longest. Chosen; the adjustment corrects it.
constexpr double kEigenvalueMin = 0.02;

/// Leading left singular vectors, from the (small) outer product.
Axes leading_axes(const Eigen::MatrixXd& columns) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(columns * columns.transpose());
  return eigen.eigenvectors().rightCols<3>().rowwise().reverse();
}

/// Per column, the standard deviation of a coordinate outside the subspace.
Eigen::VectorXd residuals(const Eigen::MatrixXd& columns, const Axes& axes) {
  const Eigen::MatrixXd outside = columns - axes * (axes.transpose() * columns);
  const double free = std::max(1.0, static_cast<double>(columns.rows() - 3));
  return outside.colwise().norm() / std::sqrt(free);
}

double median_of(Eigen::VectorXd values) {
  return median(std::span(values.data(), static_cast<std::size_t>(values.size())));
}

/// Centre of the frames' coordinates, and axes about it.
struct Hypothesis {
  Eigen::VectorXd mean;
  Axes axes;
};

Hypothesis through_sample(const ImageMatrix& images, const Sample<kSample>& sample) {
  Eigen::MatrixXd chosen(images.rows(), kSample);
  for (Eigen::Index k = 0; k < chosen.cols(); ++k) {
    chosen.col(k) = images.col(static_cast<Eigen::Index>(sample[static_cast<std::size_t>(k)]));
  }
  const Eigen::VectorXd mean = chosen.rowwise().mean();
  chosen.colwise() -= mean;
  return {.mean = mean, .axes = leading_axes(chosen)};
}

/// Residuals of the subspace whose median is the least; empty where no sample gave one.
Eigen::VectorXd consensus_residuals(const ImageMatrix& images, std::uint64_t seed) {
  const auto residuals_of = [&](const Hypothesis& h) {
    return residuals(images.colwise() - h.mean, h.axes);
  };
  BestHypothesis<Hypothesis> best;
  find_consensus<kSample>(
      {.points = static_cast<std::size_t>(images.cols()),
       .draws_max = kDraws,
       .seed = seed,
       .stream = kStream},
      [&](const Sample<kSample>& sample) { return std::optional(through_sample(images, sample)); },
      [&](const Hypothesis* h, double) { return median_of(residuals_of(*h)); },
      &best);
  return best.found() ? residuals_of(best.model) : Eigen::VectorXd();
}

int mark(const Eigen::VectorXd& r, double tolerance, AffineSubspace* s) {
  s->inliers = 0;
  s->inlier.resize(static_cast<std::size_t>(r.size()));
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    const bool good = r(i) <= tolerance;
    s->inlier[static_cast<std::size_t>(i)] = good ? 1 : 0;
    s->inliers += good ? 1 : 0;
  }
  return s->inliers;
}

Eigen::MatrixXd inlier_columns(const Eigen::MatrixXd& columns,
                               std::span<const std::uint8_t> inlier) {
  Eigen::MatrixXd out(columns.rows(), columns.cols());
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    if (inlier[static_cast<std::size_t>(i)] != 0) {
      out.col(n++) = columns.col(i);
    }
  }
  return out.leftCols(n);
}

/// Coefficients of (a^T Q b) in the six different elements of the symmetric Q.
Eigen::Matrix<double, 1, 6> quadratic_row(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  Eigen::Matrix<double, 1, 6> row;
  row << a(0) * b(0), a(1) * b(1), a(2) * b(2), a(0) * b(1) + a(1) * b(0),
      a(0) * b(2) + a(2) * b(0), a(1) * b(2) + a(2) * b(1);
  return row;
}

Eigen::Matrix3d solve_metric(const Axes& M, double isotropy) {
  const Eigen::Index frames = M.rows() / 2;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * frames + 1 + 6, 6);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
  Eigen::Matrix<double, 1, 6> size = Eigen::Matrix<double, 1, 6>::Zero();
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Vector3d m1 = M.row(f);
    const Eigen::Vector3d m2 = M.row(frames + f);
    A.row(2 * f) = quadratic_row(m1, m1) - quadratic_row(m2, m2);
    A.row(2 * f + 1) = 2.0 * quadratic_row(m1, m2);
    size += 0.5 * (quadratic_row(m1, m1) + quadratic_row(m2, m2));
  }
  const auto count = static_cast<double>(frames);
  A.row(2 * frames) = size;
  b(2 * frames) = count;
  // The isotropic body: Q a multiple of the unit matrix, with the size by the last equation.
  const double diagonal = count / size.head<3>().sum();
  const double weight = isotropy * std::sqrt(count) / diagonal;
  A.bottomRows<6>() = weight * Eigen::Matrix<double, 6, 6>::Identity();
  b.tail<6>().head<3>().setConstant(weight * diagonal);
  const Eigen::Matrix<double, 6, 1> q = A.colPivHouseholderQr().solve(b);
  Eigen::Matrix3d Q;
  Q << q(0), q(3), q(4), q(3), q(1), q(5), q(4), q(5), q(2);
  return Q;
}

}  // namespace

ImageMatrix centred(const ImageMatrix& images, std::span<const std::uint8_t> inlier) {
  return images.colwise() - inlier_columns(images, inlier).rowwise().mean();
}

AffineSubspace find_affine_subspace(const ImageMatrix& images,
                                    double sigma_normalised,
                                    std::uint64_t seed) {
  POLHODE_ASSERT(images.rows() >= 6 && images.cols() >= 8, images.cols());
  POLHODE_ASSERT(images.cols() <= static_cast<Eigen::Index>(limits::kInitialTracks), images.cols());
  AffineSubspace s;
  Eigen::VectorXd r = consensus_residuals(images, seed);
  for (int round = 0; round < kRounds; ++round) {
    const double robust_sigma = std::max(sigma_normalised, kSigmaPerMad * median_of(r));
    if (mark(r, kToleranceSigma * robust_sigma, &s) < kInliersMin) {
      return s;
    }
    const ImageMatrix relative = centred(images, s.inlier.view());
    const Eigen::MatrixXd chosen = inlier_columns(relative, s.inlier.view());
    s.axes = leading_axes(chosen);
    r = residuals(relative, s.axes);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(chosen * chosen.transpose() /
                                                               s.inliers);
    s.singular_values = eigen.eigenvalues().tail<4>().reverse().cwiseMax(0.0).cwiseSqrt();
  }
  s.valid = s.axes.allFinite();
  return s;
}

bool upgrade_to_metric(const AffineSubspace& subspace,
                       double isotropy,
                       WeakPerspectiveMotion* motion) {
  POLHODE_ASSERT(subspace.valid, subspace.inliers);
  // In these units the coordinates of an isotropic body have the same spread along each axis.
  Axes M = subspace.axes * subspace.singular_values.head<3>()
                               .cwiseMax(kSingularMin * subspace.singular_values(0))
                               .asDiagonal();
  const Eigen::Index frames = M.rows() / 2;
  const double size = std::sqrt(M.squaredNorm() / static_cast<double>(M.rows()));
  if (!(size > 0.0)) {
    return false;
  }
  M /= size;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(solve_metric(M, isotropy));
  const Eigen::Vector3d& lambda = eigen.eigenvalues();
  if (!lambda.allFinite() || !(lambda(1) > 0.0)) {
    return false;
  }
  const Eigen::Vector3d positive = lambda.cwiseMax(kEigenvalueMin * lambda(2));
  const Axes metric = size * M * eigen.eigenvectors() * positive.cwiseSqrt().asDiagonal();
  motion->R_CT.clear();
  motion->scale.clear();
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Vector3d m1 = metric.row(f);
    const Eigen::Vector3d m2 = metric.row(frames + f);
    const double scale = 0.5 * (m1.norm() + m2.norm());
    if (!(scale > 0.0)) {
      return false;
    }
    Eigen::Matrix3d R;
    R << m1.transpose() / scale, m2.transpose() / scale, m1.cross(m2).transpose() / (scale * scale);
    if (!motion->R_CT.push_back(nearest_rotation(R)) || !motion->scale.push_back(scale)) {
      return false;
    }
  }
  return true;
}

Eigen::Matrix3Xd weak_perspective_points(const ImageMatrix& images,
                                         std::span<const std::uint8_t> inlier,
                                         const WeakPerspectiveMotion& motion) {
  const Eigen::Index frames = images.rows() / 2;
  POLHODE_ASSERT(static_cast<std::size_t>(frames) == motion.R_CT.size(), motion.R_CT.size());
  Axes M(images.rows(), 3);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const auto k = static_cast<std::size_t>(f);
    M.row(f) = motion.scale[k] * motion.R_CT[k].row(0);
    M.row(frames + f) = motion.scale[k] * motion.R_CT[k].row(1);
  }
  return M.colPivHouseholderQr().solve(centred(images, inlier));
}

}  // namespace polhode
