// Initial values for the fit of a free body's rotation, and the growth of its window.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "config/limits.hpp"
#include "geometry/so3.hpp"
#include "solve/torque_free_fit.hpp"

namespace polhode {
namespace {

// Least samples: twelve coordinates for eleven unknowns.
constexpr std::size_t kSamplesMin = 4;
// Samples of the first window. Chosen: with fewer the noise hides the rate, with more a wrong shape
// loses the phase.
constexpr std::size_t kWindowFirst = 15;
// Rotation over which a mean rate is formed: large against the noise, small against the rate's
// change. Chosen.
constexpr double kChord_rad = 0.4;
// Prediction error over the next window that still converges: well under half a turn. Chosen.
constexpr double kPhaseMax_rad = 1.0;

/// Mean rate between two samples and the attitude in their middle.
struct Chord {
  Eigen::Matrix3d R_IT;
  Eigen::Vector3d w_T_rad_s;
};

Chord chord(const AttitudeSample& a, const AttitudeSample& b) {
  const Eigen::Vector3d psi = so3_log(a.R_IT.transpose() * b.R_IT);
  return {.R_IT = a.R_IT * so3_exp(0.5 * psi), .w_T_rad_s = psi / (b.time_s - a.time_s)};
}

/// End of the chord from `first`: the last sample within the angle, at least the next one.
std::size_t chord_end(std::span<const AttitudeSample> samples, std::size_t first) {
  constexpr std::size_t kLongest = 40;  // bounds the time for a body that hardly rotates
  std::size_t end = first + 1;
  while (end + 1 < samples.size() && end + 1 - first <= kLongest &&
         rotation_angle_rad(samples[first].R_IT, samples[end + 1].R_IT) < kChord_rad) {
    ++end;
  }
  return end;
}

/// The rate at the reference, by the chord around it.
Eigen::Vector3d rate_at(std::span<const AttitudeSample> samples, std::size_t reference) {
  std::size_t first = reference;
  std::size_t last = reference;
  constexpr std::size_t kReach = kWindowFirst / 2;  // samples on either side
  for (std::size_t k = 0; k < kReach; ++k) {
    const std::size_t lower = first > 0 ? first - 1 : first;
    const std::size_t upper = last + 1 < samples.size() ? last + 1 : last;
    const bool far = rotation_angle_rad(samples[lower].R_IT, samples[upper].R_IT) > kChord_rad;
    if (far && last > first) {
      break;
    }
    first = lower;
    last = upper;
  }
  return chord(samples[first], samples[last]).w_T_rad_s;
}

struct Momentum {
  InertiaShape shape = InertiaShape::Zero();          ///< for which R J w is nearest to constant
  Eigen::Vector3d axis_T = Eigen::Vector3d::UnitZ();  ///< mean axis of rotation
};

/// R J w - h = 0 in J (six numbers) and h: the least eigenvector of the normal equations.
Momentum constant_momentum(std::span<const AttitudeSample> samples) {
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  Matrix9 normal = Matrix9::Zero();
  Eigen::Vector3d sum_w = Eigen::Vector3d::Zero();
  double square = 1e-300;  // avoids a unit of zero
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const Chord c = chord(samples[i], samples[chord_end(samples, i)]);
    const Eigen::Vector3d& w = c.w_T_rad_s;
    Eigen::Matrix<double, 3, 9> row;
    // J = [a d e; d b f; e f c] in the order a, b, c, d, e, f.
    Eigen::Matrix<double, 3, 6> by_J;
    by_J << w.x(), 0.0, 0.0, w.y(), w.z(), 0.0,  //
        0.0, w.y(), 0.0, w.x(), 0.0, w.z(),      //
        0.0, 0.0, w.z(), 0.0, w.x(), w.y();
    row << c.R_IT * by_J, -Eigen::Matrix3d::Identity();
    normal += row.transpose() * row;
    square += w.squaredNorm();
    sum_w += w;
  }
  // h in units of the rate, so that its three columns have the weight of J's.
  const double unit = std::sqrt(square / static_cast<double>(samples.size()));
  normal.rightCols<3>() *= unit;
  normal.bottomRows<3>() *= unit;
  const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(normal);
  const Eigen::Matrix<double, 9, 1> x = eigen.eigenvectors().col(0);
  Eigen::Matrix3d J;
  J << x(0), x(3), x(4), x(3), x(1), x(5), x(4), x(5), x(2);
  Momentum start;
  start.shape = shape_of(J.trace() < 0.0 ? Eigen::Matrix3d(-J) : J);
  if (sum_w.norm() > 0.0) {
    start.axis_T = sum_w.normalized();
  }
  return start;
}

/// Shape of a body of revolution about `axis_T`; `stretch` > 0 a rod, < 0 a disc.
InertiaShape revolution(const Eigen::Vector3d& axis_T, double stretch) {
  const Eigen::Matrix3d log_S =
      stretch * (axis_T * axis_T.transpose() - Eigen::Matrix3d::Identity() / 3.0);
  InertiaShape shape;
  for (int k = 0; k < 5; ++k) {
    shape(k) = log_S.cwiseProduct(shape_basis(k)).sum();
  }
  return shape;
}

/// Does the solution predict both ends of the next window to kPhaseMax_rad?
bool reaches(const RotationProblem& problem,
             const RotationSolution& solution,
             std::size_t first,
             std::size_t last) {
  const Inertia inertia = inertia_of(solution.shape);
  for (const std::size_t end : {first, last - 1}) {
    RotationState state = solution.reference;
    if (!advance(inertia, problem.orbit, problem.samples[end].time_s, state, nullptr)) {
      return false;
    }
    if (rotation_angle_rad(state.R_IT, problem.samples[end].R_IT) > kPhaseMax_rad) {
      return false;
    }
  }
  return true;
}

/// Fits a window around the reference, which then grows by doubling, or by less as far as the
/// solution predicts.
Result<RotationSolution> grow(const RotationProblem& problem, const InertiaShape& shape) {
  const std::size_t count = problem.samples.size();
  const auto window = [&](std::size_t size) {
    const std::size_t half = size / 2;
    const std::size_t first = problem.reference > half ? problem.reference - half : 0;
    const std::size_t last = std::min(count, std::max(problem.reference + half + 1, first + size));
    return std::array<std::size_t, 2>{last > size ? std::min(first, last - size) : 0, last};
  };
  RotationSolution solution;
  solution.reference.time_s = problem.samples[problem.reference].time_s;
  solution.reference.R_IT = problem.samples[problem.reference].R_IT;
  solution.reference.w_T_rad_s = rate_at(problem.samples, problem.reference);
  solution.shape = shape;
  std::size_t size = std::min(kWindowFirst, count);
  // Stages at most: six doublings reach limits::kMotionPoses; the rest is for smaller growth.
  // Chosen.
  constexpr int kStagesMax = 24;
  for (int stage = 0; stage < kStagesMax; ++stage) {
    const std::array<std::size_t, 2> at = window(size);
    auto refined = refine_rotation(problem, solution, at[0], at[1]);
    if (!refined || size == count) {
      return refined;
    }
    solution = refined.value();
    // Twice the window, or less where the predicted phase is too uncertain at its ends.
    std::size_t next = std::min(count, 2 * size);
    while (next > size + 1) {
      const std::array<std::size_t, 2> wide = window(next);
      if (reaches(problem, solution, wide[0], wide[1])) {
        break;
      }
      next = size + (next - size) / 2;
    }
    size = std::max(next, size + 1);
  }
  return ErrorCode::kNotConverged;
}

}  // namespace

Result<RotationSolution> solve_rotation(const RotationProblem& problem, double chi2_per_dof_max) {
  if (problem.samples.size() < kSamplesMin) {
    return ErrorCode::kTooFewObservations;
  }
  if (problem.samples.size() > limits::kMotionPoses ||
      problem.reference >= problem.samples.size()) {
    return ErrorCode::kDegenerate;
  }
  const Momentum momentum = constant_momentum(problem.samples);
  // Shapes tried: moments of 1:5 and of 2:1.1, in the middle of the ranges of rods and discs.
  constexpr double kRod = 2.2;
  constexpr double kDisc = -2.2;
  const std::array<InertiaShape, 4> shapes{momentum.shape,
                                           InertiaShape::Zero(),
                                           revolution(momentum.axis_T, kRod),
                                           revolution(momentum.axis_T, kDisc)};
  Result<RotationSolution> best = ErrorCode::kDegenerate;
  for (const InertiaShape& shape : shapes) {
    const Result<RotationSolution> found = grow(problem, shape);
    if (found && (!best || found.value().cost < best.value().cost)) {
      best = found;
    }
    if (best && best.value().inside == problem.samples.size() &&
        chi2_per_dof(best.value()) < chi2_per_dof_max) {
      break;
    }
  }
  return best;
}

}  // namespace polhode
