#include "solve/absolute_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>

#include "base/avx2_dispatch.hpp"
#include "base/consensus.hpp"
#include "base/fixed_vector.hpp"
#include "geometry/reprojection.hpp"
#include "geometry/so3.hpp"
#include "solve/cauchy_loss.hpp"
#include "solve/small_fit.hpp"

namespace polhode {
namespace {

// Width of the Cauchy loss: a residual of 2 sigma has half its weight. It takes 9 % of the
// information of normal data, and tolerates the heavy tails of feature positions (decision 0024).
constexpr double kCauchySigma = 2.0;
// Squared error of a point behind the camera: far beyond any gate.
constexpr double kBehindError2 = 1e12;
// Points of a sample: P3P needs three; a fourth chooses among its four solutions.
constexpr int kPointsMin = 4;
constexpr std::size_t kSolutions = 4;
// Probability that all samples have outliers. Chosen; smaller draws longer.
constexpr double kMissed = 1e-3;
// Rounds of choosing inliers and refining on them. Chosen.
constexpr int kRounds = 3;

double error2(const Pose& pose, const PoseObservation& o) {
  const Eigen::Vector3d p_C = pose.to_camera(o.p_T);
  if (!(p_C.z() > 0.0)) {
    return kBehindError2;
  }
  return (p_C.hnormalized() - o.normalised).squaredNorm() /
         (o.sigma_normalised * o.sigma_normalised);
}

/// Truncated sum of squares (MSAC, Torr and Zisserman 2000): smaller is better. The sum stops once
/// it reaches `enough`.
double score(const Pose& pose, std::span<const PoseObservation> observations, double enough) {
  double sum = 0.0;
  for (std::size_t i = 0; i < observations.size() && sum < enough; ++i) {
    sum += std::min(error2(pose, observations[i]), kInlierChi2);
  }
  return sum;
}

/// Hypotheses from three points: up to four poses.
FixedVector<Pose, kSolutions> poses_through(std::span<const PoseObservation> observations,
                                            const Sample<3>& sample) {
  opengv::bearingVectors_t bearings;
  opengv::points_t points;
  for (const std::size_t i : sample) {
    bearings.push_back(observations[i].normalised.homogeneous().normalized());
    points.push_back(observations[i].p_T);
  }
  FixedVector<Pose, kSolutions> poses;
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(bearings, points);
  for (const opengv::transformation_t& T_TC : opengv::absolute_pose::p3p_kneip(adapter)) {
    const Eigen::Matrix3d R_CT = T_TC.leftCols<3>().transpose();
    if (T_TC.allFinite()) {
      (void)poses.push_back({.R_CT = R_CT, .p_CT = -R_CT * T_TC.col(3)});
    }
  }
  return poses;
}

/// The pose with the best score; a default one where no sample gave any.
Pose find_pose(std::span<const PoseObservation> observations,
               const Pose* hint,
               const AbsolutePoseOptions& options) {
  const auto score_of = [&](const Pose* pose, double enough) {
    return with_avx2([&] { return score(*pose, observations, enough); });
  };
  BestHypothesis<Pose> best;
  if (hint != nullptr) {
    consider(*hint, score_of, &best);
  }
  find_consensus<3>(
      {.points = observations.size(),
       .draws_max = options.iterations_max,
       .seed = options.seed,
       .stream = options.stream,
       .missed = kMissed,
       .score_of_none = kInlierChi2 * static_cast<double>(observations.size())},
      [&](const Sample<3>& sample) { return poses_through(observations, sample); },
      score_of,
      &best);
  return best.model;
}

/// Equations of the fit. Unknowns: phi and the shift of the position, from the initial pose.
struct PoseEquations : SmallEquations<6> {
  double chi2 = 0.0;
  int used = 0;
};

PoseEquations sum_up(std::span<const PoseObservation> observations,
                     const Pose& pose,
                     std::span<const std::uint8_t> inlier) {
  PoseEquations n;
  CauchySum robust_cost(kCauchySigma);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Eigen::Vector3d p_C = pose.to_camera(observations[i].p_T);
    if (inlier[i] == 0 || !(p_C.z() > 0.0)) {
      continue;
    }
    const double inverse_sigma = 1.0 / observations[i].sigma_normalised;
    const Eigen::Vector2d r = inverse_sigma * (p_C.hnormalized() - observations[i].normalised);
    const Eigen::Matrix<double, 2, 6> J =
        inverse_sigma * projection_jacobian(pose, observations[i].p_T);
    const double squared = r.squaredNorm();
    const double weight = cauchy_weight(squared, kCauchySigma);
    n.H += weight * J.transpose() * J;
    n.g += weight * J.transpose() * r;
    robust_cost.add(squared);
    n.chi2 += weight * squared;
    ++n.used;
  }
  n.cost = robust_cost.value();
  return n;
}

Pose moved(const Pose& start, const PoseEquations::Vector& by) {
  return {.R_CT = so3_exp(by.head<3>()) * start.R_CT, .p_CT = start.p_CT + by.tail<3>()};
}

/// Flags the observations that agree within kInlierChi2 with an uncertain pose.
int mark_within_reach(const Pose& pose,
                      const PoseCovariance& covariance,
                      std::span<const PoseObservation> observations,
                      std::span<std::uint8_t> inlier) {
  int count = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PoseObservation& o = observations[i];
    const Eigen::Vector3d p_C = pose.to_camera(o.p_T);
    inlier[i] = 0;
    if (p_C.z() > 0.0) {
      const Eigen::Vector2d r = p_C.hnormalized() - o.normalised;
      const Eigen::Matrix<double, 2, 6> J = projection_jacobian(pose, o.p_T);
      Eigen::Matrix2d S = J * covariance * J.transpose();
      S.diagonal().array() += o.sigma_normalised * o.sigma_normalised;
      inlier[i] = r.dot(S.inverse() * r) < kInlierChi2 ? 1 : 0;
      count += inlier[i];
    }
  }
  return count;
}

/// Prior of a pose: its information at the initial pose, and the part of it that counts in the
/// result's covariance.
struct Prior {
  PoseCovariance information = PoseCovariance::Zero();
  double part = 0.0;
};

/// Robust fit from `start` to the observations flagged in `inlier` and to a prior at `start`.
/// @errors as refine_pose().
Result<AbsolutePose> fit(std::span<const PoseObservation> observations,
                         const Pose& start,
                         const Prior& prior,
                         std::span<const std::uint8_t> inlier) {
  POLHODE_ASSERT(observations.size() == inlier.size(), inlier.size());
  const SmallFitOptions options{.steps_max = 12,        // chosen: three or four settle
                                .damping_first = 1e-6,  // the initial pose by P3P or by the last
                                                        // frame is near
                                .first_three = FirstThree::kRotation};
  int used_min = -1;  // points in front of the camera at first: none may fall behind it
  const auto linearise = [&](const PoseEquations::Vector& by, PoseEquations* at) {
    *at = with_avx2([&] { return sum_up(observations, moved(start, by), inlier); });
    used_min = used_min < 0 ? at->used : used_min;
    at->H += prior.information;
    at->g += prior.information * by;
    at->cost += by.dot(prior.information * by);
    return at->used >= used_min;
  };
  PoseEquations::Vector by = PoseEquations::Vector::Zero();
  PoseEquations n;
  if (minimise(linearise, options, &by, &n) < 0) {
    return ErrorCode::kDegenerate;
  }
  if (n.used < kPointsMin) {
    return ErrorCode::kTooFewObservations;
  }
  AbsolutePose out{.pose = moved(start, by), .inliers = n.used, .chi2 = n.chi2};
  out.pose.R_CT = nearest_rotation(out.pose.R_CT);
  const double reduced = n.chi2 / std::max(1.0, 2.0 * n.used - 6.0);
  const PoseCovariance counted = n.H - (1.0 - prior.part) * prior.information;
  out.covariance = counted.inverse() * std::max(1.0, reduced);
  if (!is_before_camera(out.pose) || !out.covariance.allFinite() ||
      (out.covariance.diagonal().array() <= 0.0).any()) {
    return ErrorCode::kDegenerate;
  }
  return out;
}

}  // namespace

int mark_inliers(const Pose& pose,
                 std::span<const PoseObservation> observations,
                 std::span<std::uint8_t> inlier) {
  int count = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    inlier[i] = error2(pose, observations[i]) < kInlierChi2 ? 1 : 0;
    count += inlier[i];
  }
  return count;
}

Result<AbsolutePose> refine_pose(std::span<const PoseObservation> observations,
                                 const Pose& start,
                                 std::span<const std::uint8_t> inlier) {
  return fit(observations, start, {}, inlier);
}

Result<AbsolutePose> absolute_pose(std::span<const PoseObservation> observations,
                                   const Pose* hint,
                                   const AbsolutePoseOptions& options,
                                   std::span<std::uint8_t> inlier) {
  POLHODE_ASSERT(observations.size() == inlier.size(), inlier.size());
  if (observations.size() < static_cast<std::size_t>(std::max(kPointsMin, options.inliers_min))) {
    return ErrorCode::kTooFewObservations;
  }
  Pose pose = find_pose(observations, hint, options);
  Result<AbsolutePose> refined = ErrorCode::kNoConsensus;
  for (int round = 0; round < kRounds; ++round) {
    if (mark_inliers(pose, observations, inlier) < options.inliers_min) {
      return ErrorCode::kNoConsensus;
    }
    refined = refine_pose(observations, pose, inlier);
    if (!refined) {
      return refined;
    }
    pose = refined.value().pose;
  }
  if (mark_inliers(pose, observations, inlier) < options.inliers_min) {
    return ErrorCode::kNoConsensus;
  }
  return refined;
}

Result<AbsolutePose> pose_with_prior(std::span<const PoseObservation> observations,
                                     const Pose& prior,
                                     const PoseCovariance& prior_covariance,
                                     const AbsolutePoseOptions& options,
                                     std::span<std::uint8_t> inlier) {
  POLHODE_ASSERT(observations.size() == inlier.size(), inlier.size());
  const Eigen::LLT<PoseCovariance> factor(prior_covariance);
  if (factor.info() != Eigen::Success) {
    return ErrorCode::kDegenerate;
  }
  const PoseCovariance information = factor.solve(PoseCovariance::Identity());
  if (!information.allFinite()) {
    return ErrorCode::kDegenerate;
  }
  constexpr double kPriorPart = 0.1;  // chosen: sigmas of at most three times the prior's
  const Prior known{.information = information, .part = kPriorPart};
  int count = mark_within_reach(prior, prior_covariance, observations, inlier);
  Result<AbsolutePose> found = ErrorCode::kTooFewObservations;
  for (int round = 0; round < kRounds; ++round) {
    if (count < options.inliers_min) {
      return ErrorCode::kTooFewObservations;
    }
    found = fit(observations, prior, known, inlier);
    if (!found) {
      return found;
    }
    count = mark_inliers(found.value().pose, observations, inlier);
  }
  if (count < options.inliers_min) {
    return ErrorCode::kTooFewObservations;
  }
  found.value().inliers = count;
  return found;
}

}  // namespace polhode
