#include "solve/bundle_adjustment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/assert.hpp"
#include "base/fixed_vector.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Reduced = Eigen::Map<Eigen::MatrixXd, Eigen::Aligned64>;
using Unknowns = Eigen::Map<Eigen::VectorXd, Eigen::Aligned64>;

// A diagonal element smaller than this times the largest carries no information of its own; it
// bounds what the damping leaves free.
constexpr double kDiagonalMin = 1e-12;

struct Linearised {
  Eigen::Vector2d residual;  ///< in sigma
  double weight = 0.0;       ///< of the Cauchy loss
  Eigen::Matrix<double, 2, 6> by_pose;
  Eigen::Matrix<double, 2, 3> by_point;
};

/// Normal equations of one point: its own block and its product with each moving pose that sees it.
struct PointSystem {
  struct Mixed {
    std::int32_t block = -1;
    Matrix63 W = Matrix63::Zero();
  };
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  FixedVector<Mixed, BundleWorkspace::kPoses> mixed;
};

double loss(double error2, double width_sigma) {
  const double width2 = width_sigma * width_sigma;
  return width2 * std::log1p(error2 / width2);
}

double weight(double error2, double width_sigma) {
  return 1.0 / (1.0 + error2 / (width_sigma * width_sigma));
}

class Adjustment {
 public:
  Adjustment(const BundleProblem& problem, const BundleOptions& options, BundleWorkspace* workspace)
      : p_(problem), o_(options), w_(*workspace) {
    number_blocks();
    sort_by_point();
  }

  /// Half the robust sum of squares; infinite where a point lies behind a camera that sees it.
  double cost(std::span<const InverseDepthPose> poses,
              std::span<const Eigen::Vector3d> points) const {
    double sum = 0.0;
    for (const BundleObservation& o : p_.observations) {
      Eigen::Vector2d x;
      if (!reproject(poses[index(o.pose)], points[index(o.point)], &x)) {
        return std::numeric_limits<double>::infinity();
      }
      const double error2 =
          (x - o.normalised).squaredNorm() / (o.sigma_normalised * o.sigma_normalised);
      sum += loss(error2, o_.cauchy_sigma);
    }
    return 0.5 * sum;
  }

  /// One damped step into the trial arrays.
  /// @return what the linear model gains by it, or a negative number where there is no step.
  double try_step(double damping) {
    build_reduced_system(damping);
    Reduced S(w_.reduced.data(), size_, size_);
    Eigen::LLT<Eigen::Ref<Reduced>> factor(S);
    if (factor.info() != Eigen::Success) {
      return -1.0;
    }
    Unknowns step(w_.step.data(), size_);
    factor.solveInPlace(step);
    if (!step.allFinite() || !move_poses()) {
      return -1.0;
    }
    return pose_gain(damping) + move_points(damping);
  }

  void keep_trial() {
    std::copy_n(w_.trial_poses.begin(), p_.poses.size(), p_.poses.begin());
    std::copy_n(w_.trial_points.begin(), p_.points_T.size(), p_.points_T.begin());
  }

  std::span<const InverseDepthPose> trial_poses() const { return w_.trial_poses; }
  std::span<const Eigen::Vector3d> trial_points() const { return w_.trial_points; }

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

  void number_blocks() {
    std::int32_t blocks = 0;
    for (std::size_t k = 0; k < p_.poses.size(); ++k) {
      w_.block_of_pose[k] = p_.pose_fixed[k] != 0 ? -1 : blocks++;
    }
    size_ = 6 * blocks;
  }

  /// Counting sort; the order within a point is that of the caller.
  void sort_by_point() {
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

  bool linearise(const BundleObservation& o, Linearised* out) const {
    Eigen::Vector2d x;
    ReprojectionJacobians J;
    if (!reproject(p_.poses[index(o.pose)], p_.points_T[index(o.point)], &x, &J)) {
      return false;
    }
    const double inverse_sigma = 1.0 / o.sigma_normalised;
    out->residual = inverse_sigma * (x - o.normalised);
    out->weight = weight(out->residual.squaredNorm(), o_.cauchy_sigma);
    out->by_pose << inverse_sigma * J.rotation, inverse_sigma * J.uvs;
    out->by_point = inverse_sigma * J.point;
    return true;
  }

  /// The point's equations; what its observations say of the poses alone goes into `take`.
  template <typename TakePoseTerms>
  void linearise_point(std::size_t point, PointSystem* system, TakePoseTerms take) const {
    system->V.setZero();
    system->g.setZero();
    system->mixed.clear();
    for (auto i = w_.first_of_point[point]; i < w_.first_of_point[point + 1]; ++i) {
      const BundleObservation& o = p_.observations[index(w_.by_point[index(i)])];
      Linearised l;
      if (!linearise(o, &l)) {
        continue;
      }
      system->V.noalias() += l.weight * l.by_point.transpose() * l.by_point;
      system->g.noalias() += l.weight * l.by_point.transpose() * l.residual;
      const std::int32_t block = w_.block_of_pose[index(o.pose)];
      if (block < 0) {
        continue;
      }
      take(block, l);
      if (system->mixed.empty() || system->mixed.back().block != block) {
        (void)system->mixed.push_back({.block = block, .W = Matrix63::Zero()});
      }
      system->mixed.back().W.noalias() += l.weight * l.by_pose.transpose() * l.by_point;
    }
  }

  static Eigen::Matrix3d damped_inverse(const Eigen::Matrix3d& V, double damping) {
    const double largest = V.diagonal().maxCoeff();
    if (!(largest > 0.0)) {
      return Eigen::Matrix3d::Zero();
    }
    Eigen::Matrix3d damped = V;
    damped.diagonal() += damping * V.diagonal().cwiseMax(kDiagonalMin * largest);
    return damped.inverse();
  }

  /// Reduced camera system (lower triangle) in `reduced`, its right side in `step`.
  void build_reduced_system(double damping) {
    Reduced S(w_.reduced.data(), size_, size_);
    S.setZero();
    Unknowns gradient(w_.gradient.data(), size_);
    Unknowns right(w_.step.data(), size_);
    gradient.setZero();
    right.setZero();
    std::fill_n(w_.camera_blocks.begin(), size_ / 6, Eigen::Matrix<double, 6, 6>::Zero());
    for (std::size_t point = 0; point < p_.points_T.size(); ++point) {
      linearise_point(point, &system_, [&](std::int32_t block, const Linearised& l) {
        w_.camera_blocks[index(block)].noalias() += l.weight * l.by_pose.transpose() * l.by_pose;
        gradient.segment<6>(6 * block).noalias() += l.weight * l.by_pose.transpose() * l.residual;
      });
      if (p_.point_fixed[point] == 0) {
        eliminate(system_, damped_inverse(system_.V, damping), &S, &right);
      }
    }
    right -= gradient;
    for (Eigen::Index b = 0; b < size_ / 6; ++b) {
      Eigen::Matrix<double, 6, 6> U = w_.camera_blocks[static_cast<std::size_t>(b)];
      const double largest = U.diagonal().maxCoeff();
      // A pose that sees nothing stays where it is.
      U.diagonal() += largest > 0.0
                          ? Vector6(damping * U.diagonal().cwiseMax(kDiagonalMin * largest))
                          : Vector6::Ones();
      S.block<6, 6>(6 * b, 6 * b) += U;
    }
  }

  static void eliminate(const PointSystem& system,
                        const Eigen::Matrix3d& V_inverse,
                        Reduced* S,
                        Unknowns* right) {
    for (std::size_t i = 0; i < system.mixed.size(); ++i) {
      const PointSystem::Mixed& a = system.mixed[i];
      const Matrix63 Y = a.W * V_inverse;
      right->segment<6>(6 * a.block).noalias() += Y * system.g;
      for (std::size_t j = 0; j <= i; ++j) {
        const PointSystem::Mixed& b = system.mixed[j];
        if (a.block >= b.block) {
          S->block<6, 6>(6 * a.block, 6 * b.block).noalias() -= Y * b.W.transpose();
        } else {
          S->block<6, 6>(6 * b.block, 6 * a.block).noalias() -= b.W * Y.transpose();
        }
      }
    }
  }

  /// @return false where an inverse depth would not be positive.
  bool move_poses() {
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

  /// What the linear model gains by a step x: (damping x' D x - x' g) / 2, here the poses' part.
  double pose_gain(double damping) const {
    double gain = 0.0;
    for (std::size_t b = 0; 6 * b < static_cast<std::size_t>(size_); ++b) {
      const Eigen::Map<const Vector6> step(&w_.step[6 * b]);
      const Eigen::Map<const Vector6> gradient(&w_.gradient[6 * b]);
      const Vector6 diagonal = w_.camera_blocks[b].diagonal();
      gain += 0.5 * (damping * step.cwiseAbs2().dot(diagonal) - step.dot(gradient));
    }
    return gain;
  }

  /// Points follow the poses' step. @return the points' part of the gain.
  double move_points(double damping) {
    double gain = 0.0;
    for (std::size_t point = 0; point < p_.points_T.size(); ++point) {
      w_.trial_points[point] = p_.points_T[point];
      if (p_.point_fixed[point] != 0) {
        continue;
      }
      linearise_point(point, &system_, [](std::int32_t, const Linearised&) {});
      Eigen::Vector3d right = system_.g;
      for (const PointSystem::Mixed& m : system_.mixed) {
        right += m.W.transpose() * Eigen::Map<const Vector6>(&w_.step[6 * index(m.block)]);
      }
      const Eigen::Vector3d step = -(damped_inverse(system_.V, damping) * right);
      w_.trial_points[point] += step;
      gain += 0.5 * (damping * step.cwiseAbs2().dot(system_.V.diagonal()) - step.dot(system_.g));
    }
    return gain;
  }

  const BundleProblem& p_;
  const BundleOptions& o_;
  BundleWorkspace& w_;
  PointSystem system_;
  Eigen::Index size_ = 0;
};

bool fits(const BundleProblem& problem) {
  return problem.poses.size() <= BundleWorkspace::kPoses &&
         problem.points_T.size() <= BundleWorkspace::kPoints &&
         problem.observations.size() <= BundleWorkspace::kObservations;
}

}  // namespace

BundleReport adjust_bundle(const BundleProblem& problem,
                           const BundleOptions& options,
                           BundleWorkspace* workspace) {
  POLHODE_ASSERT(problem.poses.size() == problem.pose_fixed.size(), problem.poses.size());
  POLHODE_ASSERT(problem.points_T.size() == problem.point_fixed.size(), problem.points_T.size());
  POLHODE_ASSERT(fits(problem), problem.observations.size());
  Adjustment adjustment(problem, options, workspace);
  BundleReport report;
  report.cost_before = adjustment.cost(problem.poses, problem.points_T);
  report.cost_after = report.cost_before;
  report.usable = !problem.observations.empty() && std::isfinite(report.cost_before);
  // Nielsen's damping: after a good step down to a third, after a bad one up by ever larger
  // factors. Started as for a problem that is nearly solved, which a tracked map's is.
  constexpr double kSettled = 1e-5;     // a relative gain that moves nothing by a part of its sigma
  constexpr double kGainMin = 1e-3;     // of what the linear model promised
  constexpr double kDampingMax = 1e12;  // steps are too small to matter
  double damping = 1e-4;
  double factor = 2.0;
  while (report.usable && report.iterations < options.iterations_max && damping < kDampingMax) {
    ++report.iterations;
    const double promised = adjustment.try_step(damping);
    const double cost = promised > 0.0
                            ? adjustment.cost(adjustment.trial_poses(), adjustment.trial_points())
                            : std::numeric_limits<double>::infinity();
    const double gained = report.cost_after - cost;
    if (gained > kGainMin * promised) {
      adjustment.keep_trial();
      report.cost_after = cost;
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
