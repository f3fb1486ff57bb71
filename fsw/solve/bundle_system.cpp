#include "solve/bundle_system.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"
#include "geometry/so3.hpp"
#include "solve/cauchy_loss.hpp"

namespace polhode {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Least part of the largest diagonal element that damping acts on: a weaker unknown has no
// information of its own, and the damping must still constrain it. Far above rounding.
constexpr double kDiagonalMin = 1e-12;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

Eigen::Matrix3d damped_inverse(const Eigen::Matrix3d& V, double damping) {
  const double largest = V.diagonal().maxCoeff();
  if (!(largest > 0.0)) {
    return Eigen::Matrix3d::Zero();
  }
  Eigen::Matrix3d damped = V;
  damped.diagonal() += damping * V.diagonal().cwiseMax(kDiagonalMin * largest);
  return damped.inverse();
}

// Damping of a point's own steps: for a point that is seen with next to no parallax.
constexpr double kSettlingDamping = 1e-6;

// A prior that is off by more sigmas is weighed down: 1.4 % of normal errors in six numbers are
// (chi-square).
constexpr double kPriorCauchySigma = 4.0;

Vector6 departure(const InverseDepthPose& pose, const PosePrior& prior) {
  Vector6 r;
  r << so3_log(pose.R_CT * prior.mean.R_CT.transpose()), pose.uvs - prior.mean.uvs;
  return r;
}

bool fits(const BundleProblem& problem) {
  return problem.poses.size() <= BundleWorkspace::kPoses &&
         problem.points_T.size() <= BundleWorkspace::kPoints &&
         problem.observations.size() <= BundleWorkspace::kObservations;
}

}  // namespace

/// Of one observation, in sigma.
struct BundleSystem::Linearised {
  Eigen::Matrix<double, 6, 2> by_pose;
  Eigen::Matrix<double, 4, 2> by_point;  ///< the last row is the residual
  double weight = 0.0;                   ///< of the Cauchy loss
};

BundleSystem::BundleSystem(const BundleProblem& problem,
                           double cauchy_sigma,
                           BundleWorkspace* workspace)
    : p_(problem), cauchy_sigma_(cauchy_sigma), w_(*workspace) {
  POLHODE_ASSERT(problem.poses.size() == problem.pose_fixed.size(), problem.poses.size());
  POLHODE_ASSERT(problem.points_T.size() == problem.point_fixed.size(), problem.points_T.size());
  POLHODE_ASSERT(fits(problem), problem.observations.size());
  number_blocks();
  sort_by_point();
}

double BundleSystem::cost(std::span<const InverseDepthPose> poses,
                          std::span<const Eigen::Vector3d> points) const {
  const double observations_cost = widely([&] {
    CauchySum sum(cauchy_sigma_);
    for (const BundleObservation& o : p_.observations) {
      Eigen::Vector2d x;
      if (!reproject(poses[index(o.pose)], points[index(o.point)], &x)) {
        return std::numeric_limits<double>::infinity();
      }
      sum.add((x - o.normalised).squaredNorm() / (o.sigma_normalised * o.sigma_normalised));
    }
    return sum.value();
  });
  return 0.5 * observations_cost + prior_cost(poses);
}

double BundleSystem::prior_cost(std::span<const InverseDepthPose> poses) const {
  double sum = 0.0;
  for (const PosePrior& prior : p_.priors) {
    const Vector6 r = departure(poses[index(prior.pose)], prior);
    sum += cauchy_loss(r.dot(prior.information * r), kPriorCauchySigma);
  }
  return 0.5 * sum;
}

/// The derivative of the departure is taken to be 1. Its error is half the departure in radians.
void BundleSystem::add_priors() {
  Unknowns gradient(w_.gradient.data(), size_);
  for (const PosePrior& prior : p_.priors) {
    const std::int32_t block = w_.block_of_pose[index(prior.pose)];
    if (block < 0) {
      continue;
    }
    const Vector6 r = departure(p_.poses[index(prior.pose)], prior);
    const Vector6 pull = prior.information * r;
    const double w = cauchy_weight(r.dot(pull), kPriorCauchySigma);
    w_.camera_blocks[index(block)] += w * prior.information;
    gradient.segment<6>(6 * block) += w * pull;
  }
}

void BundleSystem::keep_trial() {
  std::copy_n(w_.trial_poses.begin(), p_.poses.size(), p_.poses.begin());
  std::copy_n(w_.trial_points.begin(), p_.points_T.size(), p_.points_T.begin());
}

void BundleSystem::number_blocks() {
  std::int32_t blocks = 0;
  for (std::size_t k = 0; k < p_.poses.size(); ++k) {
    w_.block_of_pose[k] = p_.pose_fixed[k] != 0 ? -1 : blocks++;
  }
  size_ = 6 * blocks;
}

/// Counting sort; the order within a point is that of the caller.
void BundleSystem::sort_by_point() {
  auto& first = w_.first_of_point;
  std::fill_n(first.begin(), p_.points_T.size() + 1, 0);
  for (const BundleObservation& o : p_.observations) {
    ++first[index(o.point) + 1];
  }
  for (std::size_t i = 0; i < p_.points_T.size(); ++i) {
    first[i + 1] += first[i];
  }
  for (std::size_t i = 0; i < p_.observations.size(); ++i) {
    w_.by_point[index(first[index(p_.observations[i].point)]++)] = static_cast<std::int32_t>(i);
  }
  for (std::size_t i = p_.points_T.size(); i > 0; --i) {
    first[i] = first[i - 1];
  }
  first[0] = 0;
}

bool BundleSystem::linearise(const BundleObservation& o,
                             const InverseDepthPose& pose,
                             const Eigen::Vector3d& p_T,
                             Linearised* out) const {
  Eigen::Vector2d x;
  ReprojectionJacobians J;
  if (!reproject(pose, p_T, &x, &J)) {
    return false;
  }
  const double inverse_sigma = 1.0 / o.sigma_normalised;
  const Eigen::Vector2d residual = inverse_sigma * (x - o.normalised);
  out->by_pose.topRows<3>() = inverse_sigma * J.rotation.transpose();
  out->by_pose.bottomRows<3>() = inverse_sigma * J.uvs.transpose();
  out->by_point.topRows<3>() = inverse_sigma * J.point.transpose();
  out->by_point.row(3) = residual.transpose();
  out->weight = cauchy_weight(residual.squaredNorm(), cauchy_sigma_);
  return true;
}

/// @param take  (block of the pose or -1, Linearised) of each observation of the point, were it at
/// p_T
/// @return false where it lies behind a camera; that observation is left out.
template <typename Take>
bool BundleSystem::for_observations(std::size_t point,
                                    std::span<const InverseDepthPose> poses,
                                    const Eigen::Vector3d& p_T,
                                    Take take) const {
  bool all = true;
  for (auto i = w_.first_of_point[point]; i < w_.first_of_point[point + 1]; ++i) {
    const BundleObservation& o = p_.observations[index(w_.by_point[index(i)])];
    Linearised l;
    if (linearise(o, poses[index(o.pose)], p_T, &l)) {
      take(w_.block_of_pose[index(o.pose)], l);
    } else {
      all = false;
    }
  }
  return all;
}

void BundleSystem::fill_point_system(std::size_t point) {
  Eigen::Matrix4d V = Eigen::Matrix4d::Zero();
  system_.mixed.clear();
  (void)for_observations(
      point, p_.poses, p_.points_T[point], [&](std::int32_t block, const Linearised& l) {
        const Eigen::Matrix<double, 4, 2> weighted = l.weight * l.by_point;
        V.noalias() += l.by_point * weighted.transpose();
        if (block < 0) {
          return;
        }
        const Eigen::Matrix<double, 6, 2> weighted_by_pose = l.weight * l.by_pose;
        w_.camera_blocks[index(block)].noalias() += l.by_pose * weighted_by_pose.transpose();
        const Eigen::Matrix<double, 6, 4> W = l.by_pose * weighted.transpose();
        if (!system_.mixed.empty() && system_.mixed.back().block == block) {
          system_.mixed.back().W += W;
        } else {
          (void)system_.mixed.push_back({.block = block, .W = W});
        }
      });
  system_.V = V;
}

void BundleSystem::eliminate(const Eigen::Matrix3d& V_inverse) {
  Unknowns right = step();
  Reduced S = reduced();
  const Eigen::Vector3d g = system_.V.col(3).head<3>();
  for (std::size_t i = 0; i < system_.mixed.size(); ++i) {
    const PointSystem::Mixed& a = system_.mixed[i];
    const Eigen::Matrix<double, 6, 3> Y = a.W.leftCols<3>() * V_inverse;
    system_.W_V_inverse[i] = Y;
    right.segment<6>(6 * a.block).noalias() += Y * g;
    for (std::size_t j = 0; j <= i; ++j) {
      const PointSystem::Mixed& b = system_.mixed[j];
      if (a.block >= b.block) {
        S.block<6, 6>(6 * a.block, 6 * b.block).noalias() -= Y * b.W.leftCols<3>().transpose();
      } else {
        S.block<6, 6>(6 * b.block, 6 * a.block).noalias() -=
            system_.W_V_inverse[j] * a.W.leftCols<3>().transpose();
      }
    }
  }
}

void BundleSystem::add_points(double damping) {
  Unknowns gradient(w_.gradient.data(), size_);
  for (std::size_t point = 0; point < p_.points_T.size(); ++point) {
    fill_point_system(point);
    for (const PointSystem::Mixed& m : system_.mixed) {
      gradient.segment<6>(6 * m.block) += m.W.col(3);
    }
    if (p_.point_fixed[point] == 0) {
      eliminate(damped_inverse(system_.V.topLeftCorner<3, 3>(), damping));
    }
  }
}

void BundleSystem::add_poses(double damping) {
  Reduced S = reduced();
  for (Eigen::Index b = 0; b < size_ / 6; ++b) {
    Eigen::Matrix<double, 6, 6> U = w_.camera_blocks[static_cast<std::size_t>(b)];
    const double largest = U.diagonal().maxCoeff();
    // A pose without observations stays.
    U.diagonal() += largest > 0.0 ? Vector6(damping * U.diagonal().cwiseMax(kDiagonalMin * largest))
                                  : Vector6::Ones();
    S.block<6, 6>(6 * b, 6 * b) += U;
  }
}

void BundleSystem::build(double damping) {
  reduced().setZero();
  step().setZero();
  Unknowns gradient(w_.gradient.data(), size_);
  gradient.setZero();
  std::fill_n(w_.camera_blocks.begin(), size_ / 6, Eigen::Matrix<double, 6, 6>::Zero());
  widely([&] { add_points(damping); });
  add_priors();
  step() -= gradient;
  add_poses(damping);
}

bool BundleSystem::move_poses() {
  for (std::size_t k = 0; k < p_.poses.size(); ++k) {
    w_.trial_poses[k] = p_.poses[k];
    if (w_.block_of_pose[k] < 0) {
      continue;
    }
    const Eigen::Map<const Vector6> step(&w_.step[6 * index(w_.block_of_pose[k])]);
    w_.trial_poses[k].R_CT = so3_exp(step.head<3>()) * p_.poses[k].R_CT;
    w_.trial_poses[k].uvs += step.tail<3>();
    if (!(w_.trial_poses[k].uvs.z() > 0.0)) {
      return false;
    }
  }
  return true;
}

double BundleSystem::pose_gain(double damping) const {
  double gain = 0.0;
  for (std::size_t b = 0; 6 * b < static_cast<std::size_t>(size_); ++b) {
    const Eigen::Map<const Vector6> step(&w_.step[6 * b]);
    const Eigen::Map<const Vector6> gradient(&w_.gradient[6 * b]);
    const Vector6 diagonal = w_.camera_blocks[b].diagonal();
    gain += 0.5 * (damping * step.cwiseAbs2().dot(diagonal) - step.dot(gradient));
  }
  return gain;
}

/// @return cost that the linear model gains by it.
double BundleSystem::move_point(std::size_t point, double damping) {
  Eigen::Matrix4d V = Eigen::Matrix4d::Zero();
  Eigen::Vector3d by_poses = Eigen::Vector3d::Zero();
  (void)for_observations(
      point, p_.poses, p_.points_T[point], [&](std::int32_t block, const Linearised& l) {
        const Eigen::Matrix<double, 4, 2> weighted = l.weight * l.by_point;
        V.noalias() += l.by_point * weighted.transpose();
        if (block >= 0) {
          const Eigen::Map<const Vector6> step(&w_.step[6 * index(block)]);
          const Eigen::Vector2d moved = l.by_pose.transpose() * step;
          by_poses.noalias() += weighted.topRows<3>() * moved;
        }
      });
  const Eigen::Matrix3d own = V.topLeftCorner<3, 3>();
  const Eigen::Vector3d g = V.col(3).head<3>();
  const Eigen::Vector3d step = -(damped_inverse(own, damping) * (g + by_poses));
  w_.trial_points[point] = p_.points_T[point] + step;
  return 0.5 * (damping * step.cwiseAbs2().dot(own.diagonal()) - step.dot(g));
}

double BundleSystem::move_points(double damping) {
  double gain = pose_gain(damping);
  widely([&] {
    for (std::size_t point = 0; point < p_.points_T.size(); ++point) {
      if (p_.point_fixed[point] == 0) {
        gain += move_point(point, damping);
      } else {
        w_.trial_points[point] = p_.points_T[point];
      }
    }
  });
  return gain;
}

/// @return twice its part of the trial's cost.
double BundleSystem::settle_point(std::size_t point) {
  // Two Gauss-Newton steps follow a pose step of several degrees (docs/decisions/0043).
  constexpr int kSettlingSteps = 2;
  const int steps = p_.point_fixed[point] == 0 ? kSettlingSteps : 0;
  double least = std::numeric_limits<double>::infinity();
  Eigen::Vector3d p_T = p_.points_T[point];
  for (int k = 0; k <= steps; ++k) {
    Eigen::Matrix4d V = Eigen::Matrix4d::Zero();
    CauchySum sum(cauchy_sigma_);
    const bool seen =
        for_observations(point, w_.trial_poses, p_T, [&](std::int32_t, const Linearised& l) {
          sum.add(l.by_point.row(3).squaredNorm());
          const Eigen::Matrix<double, 4, 2> weighted = l.weight * l.by_point;
          V.noalias() += l.by_point * weighted.transpose();
        });
    const double cost = sum.value();
    if (!seen || !(cost < least)) {
      return least;
    }
    least = cost;
    w_.trial_points[point] = p_T;
    p_T -= damped_inverse(V.topLeftCorner<3, 3>(), kSettlingDamping) * V.col(3).head<3>();
  }
  return least;
}

double BundleSystem::settle_points() {
  const double observations_cost = widely([&] {
    double sum = 0.0;
    for (std::size_t point = 0; point < p_.points_T.size(); ++point) {
      sum += settle_point(point);
    }
    return sum;
  });
  return 0.5 * observations_cost + prior_cost(w_.trial_poses);
}

}  // namespace polhode
