// The linearised system of a bundle with its points eliminated, and the damped steps: shared by all
// adjustments of poses and points.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "base/fixed_vector.hpp"
#include "solve/bundle_problem.hpp"

namespace polhode {

/// A problem linearised at its present poses and points. The workspace holds the trial poses and
/// points.
class BundleSystem {
 public:
  using Reduced = Eigen::Map<Eigen::MatrixXd, Eigen::Aligned64>;
  using Unknowns = Eigen::Map<Eigen::VectorXd, Eigen::Aligned64>;

  BundleSystem(const BundleProblem& problem, double cauchy_sigma, BundleWorkspace* workspace);

  /// Six for each moving pose, in the order of the poses: phi of R = exp(phi) R_CT, then uvs.
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Half the robust sum of squares; infinite where a point lies behind a camera that sees it.
  [[nodiscard]] double cost(std::span<const InverseDepthPose> poses,
                            std::span<const Eigen::Vector3d> points) const;
  [[nodiscard]] double cost() const { return cost(p_.poses, p_.points_T); }
  [[nodiscard]] double trial_cost() const { return cost(w_.trial_poses, w_.trial_points); }

  /// Fills reduced() (lower triangle), and step() with the right side of reduced() * step = right.
  void build(double damping);
  [[nodiscard]] Reduced reduced() { return {w_.reduced.data(), size_, size_}; }
  [[nodiscard]] Unknowns step() { return {w_.step.data(), size_}; }

  /// The trial's poses by step(). @return false where an inverse depth would not be positive.
  bool move_poses();

  /// The trial's points, by back-substitution of step(). @return cost that the linear model gains
  /// by both: for a step x that solves the damped system, (damping x' D x - x' g) / 2.
  double move_points(double damping);

  /// Re-solves each point for the trial poses (two Gauss-Newton steps); valid for large pose steps,
  /// where the linear model of all unknowns fails. @return trial_cost().
  double settle_points();

  [[nodiscard]] std::span<InverseDepthPose> trial_poses() {
    return std::span(w_.trial_poses).first(p_.poses.size());
  }
  void keep_trial();

 private:
  struct Linearised;
  /// Normal equations of one point. The last column is the gradient: (V, g) of the point itself,
  /// (W, gradient) of each moving pose that sees it.
  struct PointSystem {
    struct Mixed {
      std::int32_t block = -1;
      Eigen::Matrix<double, 6, 4> W;
    };
    Eigen::Matrix4d V;
    FixedVector<Mixed, BundleWorkspace::kPoses> mixed;
    std::array<Eigen::Matrix<double, 6, 3>, BundleWorkspace::kPoses>
        W_V_inverse;  ///< by place in `mixed`
  };

  void number_blocks();
  void sort_by_point();
  bool linearise(const BundleObservation& observation,
                 const InverseDepthPose& pose,
                 const Eigen::Vector3d& p_T,
                 Linearised* out) const;
  template <typename Take>
  bool for_observations(std::size_t point,
                        std::span<const InverseDepthPose> poses,
                        const Eigen::Vector3d& p_T,
                        Take take) const;
  void add_points(double damping);
  void fill_point_system(std::size_t point);
  void eliminate(const Eigen::Matrix3d& V_inverse);
  void add_priors();
  void add_poses(double damping);
  double move_point(std::size_t point, double damping);
  double settle_point(std::size_t point);
  [[nodiscard]] double prior_cost(std::span<const InverseDepthPose> poses) const;
  [[nodiscard]] double pose_gain(double damping) const;

  const BundleProblem& p_;
  double cauchy_sigma_;
  BundleWorkspace& w_;
  PointSystem system_;
  Eigen::Index size_ = 0;
};

/// Nielsen's damping: down to a third after a good step; up by 2, 4, 8, ... after bad ones. Third,
/// 2 and kGainMin are Ceres's, too.
/// @param try_step    damping -> cost that the linear model gains by the trial; not positive: there
/// is no trial.
/// @param trial_cost  of that trial.
/// @param keep_trial  makes it the state.
/// @source Nielsen, IMM-REP-1999-05.
template <typename TryStep, typename TrialCost, typename KeepTrial>
BundleReport take_damped_steps(double cost,
                               int iterations_max,
                               double damping,
                               TryStep try_step,
                               TrialCost trial_cost,
                               KeepTrial keep_trial) {
  // Relative gain. Small, because weak directions settle last (docs/decisions/0041).
  constexpr double kSettled = 1e-5;
  constexpr double kGainMin = 1e-3;     // part of what the linear model promised
  constexpr double kDampingMax = 1e12;  // beyond it steps are too small to matter
  BundleReport report{.usable = std::isfinite(cost), .cost_before = cost, .cost_after = cost};
  double factor = 2.0;
  while (report.usable && report.iterations < iterations_max && damping < kDampingMax) {
    ++report.iterations;
    const double promised = try_step(damping);
    const double reached = promised > 0.0 ? trial_cost() : std::numeric_limits<double>::infinity();
    const double gained = report.cost_after - reached;
    if (gained > kGainMin * promised) {
      keep_trial();
      report.cost_after = reached;
      const double quality = gained / promised;
      damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * quality - 1.0, 3));
      factor = 2.0;
    } else {
      damping *= factor;
      factor *= 2.0;
    }
    if (std::abs(gained) <= kSettled * report.cost_after) {
      break;
    }
  }
  return report;
}

}  // namespace polhode
