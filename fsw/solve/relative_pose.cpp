#include "solve/relative_pose.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/relative_pose/methods.hpp>

#include "base/assert.hpp"
#include "base/consensus.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

// Gate: chi-square of one coordinate, 3 sigma: 99.7 %. Larger errors all count the same.
constexpr double kSampsonMax2 = 9.0;
// Least pairs: five determine the essential matrix, the others choose among its solutions. Chosen.
constexpr std::size_t kPairsMin = 8;
// Roots of the five-point problem's polynomial.
constexpr std::size_t kSolutions = 10;
// "5P": the random stream of this sampler.
constexpr std::uint64_t kStream = 0x3550ULL;

struct Pairs {
  std::span<const Eigen::Vector2d> x_a;
  std::span<const Eigen::Vector2d> x_b;
  double inverse_sigma2;
};

struct Essential {
  Eigen::Matrix3d E;
  int inliers = 0;
};
using Essentials = FixedVector<Essential, kSolutions>;

/// Truncated sum of squares, and the inliers.
double score_of(const Pairs& pairs, Essential* essential) {
  double sum = 0.0;
  essential->inliers = 0;
  for (std::size_t i = 0; i < pairs.x_a.size(); ++i) {
    const double e = sampson_error(essential->E, pairs.x_a[i], pairs.x_b[i]);
    const double e2 = e * e * pairs.inverse_sigma2;
    sum += std::min(e2, kSampsonMax2);
    essential->inliers += e2 < kSampsonMax2 ? 1 : 0;
  }
  return sum;
}

/// Of the four motions of an essential matrix, the one with most points in front of both cameras.
RelativePose choose_in_front(const Eigen::Matrix3d& E, const Pairs& pairs) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  Eigen::Matrix3d V = svd.matrixV();
  U *= U.determinant() < 0.0 ? -1.0 : 1.0;
  V *= V.determinant() < 0.0 ? -1.0 : 1.0;
  Eigen::Matrix3d W;
  W << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  RelativePose best;
  int best_count = -1;
  for (int k = 0; k < 4; ++k) {
    RelativePose motion;
    motion.R_ba = U * (k < 2 ? W : Eigen::Matrix3d(W.transpose())) * V.transpose();
    motion.p_ba = k % 2 == 0 ? U.col(2) : Eigen::Vector3d(-U.col(2));
    int count = 0;
    for (std::size_t i = 0; i < pairs.x_a.size(); ++i) {
      const double depth = depth_in_a(motion, pairs.x_a[i], pairs.x_b[i]);
      const double depth_b = (motion.R_ba * (depth * pairs.x_a[i].homogeneous()) + motion.p_ba).z();
      count += std::isfinite(depth) && depth > 0.0 && depth_b > 0.0 ? 1 : 0;
    }
    if (count > best_count) {
      best_count = count;
      best = motion;
    }
  }
  return best;
}

Essentials essentials_through(const Pairs& pairs, const Sample<5>& sample) {
  opengv::bearingVectors_t a;
  opengv::bearingVectors_t b;
  for (const std::size_t i : sample) {
    a.push_back(pairs.x_a[i].homogeneous().normalized());
    b.push_back(pairs.x_b[i].homogeneous().normalized());
  }
  // OpenGV's E obeys a^T E b = 0 for adapter(a, b); ours b^T E a = 0, so the roles are swapped.
  opengv::relative_pose::CentralRelativeAdapter adapter(b, a);
  Essentials essentials;
  for (const Eigen::Matrix3d& E : opengv::relative_pose::fivept_nister(adapter)) {
    if (E.allFinite()) {
      (void)essentials.push_back({.E = E});
    }
  }
  return essentials;
}

/// Keeps the list sorted, with one candidate per rotation.
void insert(const RelativePoseCandidate& candidate, RelativePoseCandidates* list) {
  // Least difference, 1.7 deg: closer rotations refine to the same minimum. Chosen; larger loses
  // different ones.
  constexpr double kSameRotation_rad = 0.03;
  for (std::size_t i = 0; i < list->size(); ++i) {
    if (rotation_angle_rad((*list)[i].motion.R_ba, candidate.motion.R_ba) < kSameRotation_rad) {
      if (candidate.score >= (*list)[i].score) {
        return;
      }
      list->erase(i);
      break;
    }
  }
  if (list->full()) {
    if (candidate.score >= list->back().score) {
      return;
    }
    list->pop_back();
  }
  (void)list->push_back(candidate);
  for (std::size_t i = list->size() - 1; i > 0 && (*list)[i].score < (*list)[i - 1].score; --i) {
    std::swap((*list)[i], (*list)[i - 1]);
  }
}

/// The hypotheses that find_consensus() keeps here: the best few that differ.
struct BestDifferent {
  const Pairs& pairs;
  RelativePoseCandidates list;

  [[nodiscard]] double bound() const { return list.full() ? list.back().score : kNoScore; }
  void keep(const Essential& essential, double score) {
    insert({.motion = choose_in_front(essential.E, pairs),
            .score = score,
            .inliers = essential.inliers},
           &list);
  }
};

}  // namespace

double depth_in_a(const RelativePose& motion,
                  const Eigen::Vector2d& x_a,
                  const Eigen::Vector2d& x_b) {
  // x_b x (z R x_a + p) = 0, least squares for z.
  const Eigen::Vector3d b = x_b.homogeneous();
  const Eigen::Vector3d moving = b.cross(motion.R_ba * x_a.homogeneous());
  return -moving.dot(b.cross(motion.p_ba)) / moving.squaredNorm();
}

RelativePoseCandidates find_relative_poses(std::span<const Eigen::Vector2d> x_a,
                                           std::span<const Eigen::Vector2d> x_b,
                                           const TwoViewOptions& options) {
  POLHODE_ASSERT(x_a.size() == x_b.size(), x_a.size());
  if (x_a.size() < kPairsMin) {
    return {};
  }
  const Pairs pairs{x_a, x_b, 1.0 / (options.sigma_normalised * options.sigma_normalised)};
  BestDifferent best{.pairs = pairs, .list = {}};
  find_consensus<5>(
      {.points = x_a.size(), .draws_max = options.samples, .seed = options.seed, .stream = kStream},
      [&](const Sample<5>& sample) { return essentials_through(pairs, sample); },
      [&](Essential* essential, double) { return score_of(pairs, essential); },
      &best);
  return best.list;
}

}  // namespace polhode
