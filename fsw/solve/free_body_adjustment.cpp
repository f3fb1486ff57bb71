#include "solve/free_body_adjustment.hpp"

#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numeric>
#include <vector>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"
#include "base/index.hpp"
#include "geometry/so3.hpp"
#include "solve/bundle_part.hpp"
#include "solve/ceres_solver.hpp"
#include "solve/settle_points.hpp"

namespace polhode {
namespace {

using ByUnknowns = Eigen::Matrix<double, 6, kFreeBodyUnknowns>;
using PointByUnknowns = Eigen::Matrix<double, 3, kFreeBodyUnknowns>;
// Rotation, translation and scale of T.
constexpr int kGaugeRows = 7;
using GaugeRows = Eigen::Matrix<double, kGaugeRows, kFreeBodyUnknowns>;
template <int kRows>
using JacobianMap = Eigen::Map<Eigen::Matrix<double, kRows, kFreeBodyUnknowns, Eigen::RowMajor>>;

// Those of shape and mass centre, which have a prior.
constexpr int kPriorNumbers = 8;
// From where the linear model puts them, two steps settle points after a pose step of several
// degrees (decision 0043).
constexpr int kSettlingSteps = 2;
// The first motion may be further off. Chosen: points follow it by small steps.
constexpr int kFirstSettlingSteps = 5;

/// Position of T's origin in I, and its derivatives by the unknowns.
struct Place {
  Eigen::Vector3d p_I;
  Eigen::Matrix<double, 3, kFreeBodyUnknowns> by_unknowns;
};

Place place_of(const FreeBodyMotion& motion,
               const RotationState& state,
               const RotationJacobian& attitude_I) {
  const double reference_s = motion.reference.time_s;
  const Eigen::Matrix<double, 6, 6> transition =
      translation_transition(motion.orbit, reference_s, state.time_s - reference_s);
  const Eigen::Vector3d offset_I = state.R_IT * motion.path.tail<3>();
  Place place;
  place.p_I = transition.topRows<3>() * motion.path.head<6>() - offset_I;
  // An attitude error phi moves the offset R c by phi x R c.
  place.by_unknowns << hat(offset_I) * attitude_I, transition.topRows<3>(), -state.R_IT;
  return place;
}

/// Computes the poses from the motion, and re-solves the points. Ceres calls it before each
/// evaluation, so Euler's equation is integrated once for all observations.
class MotionAndPoints final : public ceres::EvaluationCallback {
 public:
  MotionAndPoints(const FreeBodyProblem& problem, double cauchy_sigma)
      : p_(problem),
        cauchy_sigma_(cauchy_sigma),
        by_point_(problem.bundle.observations, problem.bundle.points_T.size()),
        in_order_of_time_(problem.bundle.poses.size()),
        pose_by_unknowns_(problem.bundle.poses.size()),
        points_T_(problem.bundle.points_T.begin(), problem.bundle.points_T.end()),
        point_by_unknowns_(problem.bundle.points_T.size(), PointByUnknowns::Zero()),
        of_poses_(problem.bundle.poses.size()) {
    std::iota(in_order_of_time_.begin(), in_order_of_time_.end(), std::size_t{0});
    std::sort(in_order_of_time_.begin(), in_order_of_time_.end(), [&](auto a, auto b) {
      return p_.times[a].time_s < p_.times[b].time_s;
    });
    Eigen::Map<FreeBodyVector>{unknowns.data()} << Eigen::Vector3d::Zero(),
        p_.motion->reference.w_T_rad_s, p_.motion->shape, p_.motion->path;
    kept_unknowns_ = Eigen::Map<FreeBodyVector>(unknowns.data());
  }

  /// Attitude at the reference as a turn from that of the start, then rate, shape, path.
  std::array<double, kFreeBodyUnknowns> unknowns{};

  [[nodiscard]] FreeBodyMotion motion() const {
    const Eigen::Map<const FreeBodyVector> x(unknowns.data());
    FreeBodyMotion motion = *p_.motion;
    motion.reference.R_IT = so3_exp(x.head<3>()) * p_.motion->reference.R_IT;
    motion.reference.w_T_rad_s = x.segment<3>(3);
    motion.shape = x.segment<kShapeNumbers>(kRotationUnknowns - kShapeNumbers);
    motion.path = x.tail<kTranslationUnknowns>();
    return motion;
  }

  /// Derivatives are requested for an accepted motion: its points are accepted, too.
  void PrepareForEvaluation(bool with_derivatives, bool is_new) override {
    if (is_new) {
      possible_ = pose() && settle();
    }
    if (with_derivatives && possible_) {
      std::copy(points_T_.begin(), points_T_.end(), p_.bundle.points_T.begin());
      kept_unknowns_ = Eigen::Map<const FreeBodyVector>(unknowns.data());
      possible_ = linearise_motion();
      linearise_points();
      settling_steps_ = kSettlingSteps;
    }
  }

  /// The poses by the motion. @return false where the integration fails or a pose lies behind the
  /// camera.
  bool pose() {
    const FreeBodyMotion m = motion();
    return trace(
        m, nullptr, [&](std::size_t k, const RotationState& state, const RotationDerivative&) {
          const auto R_CI = p_.times[k].R_IC.transpose();
          const Pose pose{.R_CT = R_CI * state.R_IT,
                          .p_CT = R_CI * place_of(m, state, RotationJacobian::Zero()).p_I};
          const bool in_front = is_before_camera(pose);
          if (in_front) {
            p_.bundle.poses[k] = to_inverse_depth(pose);
          }
          return in_front;
        });
  }

  /// Cost of the present poses and points, priors included.
  [[nodiscard]] double cost() const {
    const Eigen::Map<const FreeBodyVector> x(unknowns.data());
    return bundle_cost(p_.bundle, cauchy_sigma_) + 0.5 * prior().dot(x.cwiseAbs2());
  }

  [[nodiscard]] bool possible() const { return possible_; }
  [[nodiscard]] const InverseDepthPose& pose_of(const BundleObservation& o) const {
    return p_.bundle.poses[index(o.pose)];
  }
  [[nodiscard]] const Eigen::Vector3d& point_of(const BundleObservation& o) const {
    return points_T_[index(o.point)];
  }
  [[nodiscard]] const ByUnknowns& pose_by_unknowns(const BundleObservation& o) const {
    return pose_by_unknowns_[index(o.pose)];
  }
  [[nodiscard]] const PointByUnknowns& point_by_unknowns(const BundleObservation& o) const {
    return point_by_unknowns_[index(o.point)];
  }

  /// The least cost over all points as a quadratic of the unknowns, about the last motion kept.
  [[nodiscard]] FreeBodyInformation information() const {
    // Sigma of the gauge, rad and parts of the extent: far below any sigma of the images, far above
    // rounding.
    constexpr double kGaugeSigma = 1e-6;
    const GaugeRows constraint = gauge_ / (kGaugeSigma * static_cast<double>(count()));
    return information_ + constraint.transpose() * constraint;
  }

 private:
  [[nodiscard]] std::size_t count() const { return p_.bundle.poses.size(); }

  /// Calls `take` for each pose with the state at its time, and with the derivatives if `begin` is
  /// given.
  template <typename Take>
  bool trace(const FreeBodyMotion& motion, const RotationDerivative* begin, Take take) const {
    const Inertia inertia = inertia_of(motion.shape);
    const auto& order = in_order_of_time_;
    const auto later = std::find_if(order.begin(), order.end(), [&](std::size_t k) {
      return p_.times[k].time_s >= motion.reference.time_s;
    });
    const auto integrate = [&](auto first, auto last) {
      RotationState state = motion.reference;
      RotationDerivative derivative = begin != nullptr ? *begin : RotationDerivative{};
      return std::all_of(first, last, [&](std::size_t k) {
        return advance(inertia,
                       motion.orbit,
                       p_.times[k].time_s,
                       state,
                       begin != nullptr ? &derivative : nullptr) &&
               take(k, state, derivative);
      });
    };
    return integrate(later, order.end()) &&
           integrate(std::make_reverse_iterator(later), std::make_reverse_iterator(order.begin()));
  }

  /// Re-solves the points, beginning at their predictions by the linear model.
  bool settle() {
    const FreeBodyVector step = Eigen::Map<const FreeBodyVector>(unknowns.data()) - kept_unknowns_;
    for (std::size_t i = 0; i < points_T_.size(); ++i) {
      points_T_[i] = p_.bundle.points_T[i] + point_by_unknowns_[i] * step;
      if (!std::isfinite(settle_point(by_point_.of(i),
                                      p_.bundle.poses,
                                      cauchy_sigma_,
                                      p_.bundle.point_fixed[i] == 0 ? settling_steps_ : 0,
                                      &points_T_[i]))) {
        return false;
      }
    }
    return true;
  }

  bool linearise_motion() {
    const FreeBodyMotion m = motion();
    RotationDerivative begin = RotationDerivative::at_reference();
    begin.attitude_I.leftCols<3>() =
        so3_left_jacobian(Eigen::Map<Eigen::Vector3d>(unknowns.data()));
    gauge_.setZero();
    return trace(
        m, &begin, [&](std::size_t k, const RotationState& state, const RotationDerivative& by) {
          const Place place = place_of(m, state, by.attitude_I);
          const auto R_CI = p_.times[k].R_IC.transpose();
          Eigen::Matrix<double, 3, kFreeBodyUnknowns> rotation;
          rotation << by.attitude_I, Eigen::Matrix<double, 3, kTranslationUnknowns>::Zero();
          pose_by_unknowns_[k] << R_CI * rotation,
              uvs_by_position(R_CI * place.p_I) * (R_CI * place.by_unknowns);
          gauge_.topRows<3>() += state.R_IT.transpose() * rotation;
          gauge_.middleRows<3>(3) +=
              state.R_IT.transpose() * place.by_unknowns / p_.mass_centre_sigma;
          gauge_.row(6) += place.p_I.transpose() * place.by_unknowns / place.p_I.squaredNorm();
          return true;
        });
  }

  /// Derivatives of each settled point by the unknowns; their information, with points eliminated.
  void linearise_points() {
    information_ = prior().asDiagonal();
    with_avx2([&] {
      std::fill(of_poses_.begin(), of_poses_.end(), Eigen::Matrix<double, 6, 6>::Zero());
      for (std::size_t i = 0; i < points_T_.size(); ++i) {
        linearise_point(i);
      }
      for (std::size_t k = 0; k < count(); ++k) {
        const ByUnknowns moved = of_poses_[k] * pose_by_unknowns_[k];
        information_.noalias() += pose_by_unknowns_[k].transpose() * moved;
      }
    });
    information_ = FreeBodyInformation(0.5 * (information_ + information_.transpose()));
  }

  void linearise_point(std::size_t i) {
    // Damping of points that are seen without parallax; otherwise next to nothing.
    constexpr double kPointDamping = 1e-9;
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    PointByUnknowns W = PointByUnknowns::Zero();
    for (const BundleObservation& o : by_point_.of(i)) {
      LinearisedObservation l;
      (void)linearise(o, pose_of(o), points_T_[i], cauchy_sigma_, &l);  // settle() has seen it
      const Eigen::Matrix<double, 3, 2> weighted = l.weight * l.by_point.transpose();
      const Eigen::Matrix<double, 3, 6> mixed = weighted * l.by_pose;
      const Eigen::Matrix<double, 2, 6> weighted_by_pose = l.weight * l.by_pose;
      V.noalias() += weighted * l.by_point;
      W.noalias() += mixed * pose_by_unknowns(o);
      of_poses_[index(o.pose)].noalias() += l.by_pose.transpose() * weighted_by_pose;
    }
    if (p_.bundle.point_fixed[i] == 0) {
      point_by_unknowns_[i].noalias() = -damped_inverse(V, kPointDamping) * W;
    } else {
      point_by_unknowns_[i].setZero();
    }
    information_.noalias() += W.transpose() * point_by_unknowns_[i];
  }

  [[nodiscard]] FreeBodyVector prior() const {
    FreeBodyVector information = FreeBodyVector::Zero();
    information.segment<kShapeNumbers>(kRotationUnknowns - kShapeNumbers)
        .setConstant(1.0 / (p_.shape_sigma * p_.shape_sigma));
    information.tail<3>().setConstant(1.0 / (p_.mass_centre_sigma * p_.mass_centre_sigma));
    return information;
  }

  const FreeBodyProblem& p_;
  double cauchy_sigma_;
  PointObservations by_point_;
  std::vector<std::size_t> in_order_of_time_;
  std::vector<ByUnknowns> pose_by_unknowns_;        ///< (phi, uvs)
  std::vector<Eigen::Vector3d> points_T_;           ///< settled at the present motion
  std::vector<PointByUnknowns> point_by_unknowns_;  ///< how they follow the last motion kept
  FreeBodyVector kept_unknowns_;
  std::vector<Eigen::Matrix<double, 6, 6>> of_poses_;  ///< information of each for itself
  int settling_steps_ = kFirstSettlingSteps;
  bool possible_ = false;
  GaugeRows gauge_ = GaugeRows::Zero();  ///< T's turn, shift (in extents) and scale, over all poses
  FreeBodyInformation information_ = FreeBodyInformation::Zero();
};

/// Residual of an observation, in sigma; its point follows the motion.
class FollowedPointCost final : public ceres::SizedCostFunction<2, kFreeBodyUnknowns> {
 public:
  FollowedPointCost(const BundleObservation& observation, const MotionAndPoints& at)
      : o_(observation), at_(at) {}

  bool Evaluate(double const* const* /*parameters*/,
                double* residuals,
                double** jacobians) const override {
    double* J = jacobians != nullptr ? jacobians[0] : nullptr;
    return at_.possible() && with_avx2([&] { return evaluate(residuals, J); });
  }

 private:
  bool evaluate(double* residuals, double* jacobian) const {
    LinearisedObservation l;
    // Ceres weighs by the loss.
    constexpr double kAnyWidth = 1.0;
    if (!linearise(o_, at_.pose_of(o_), at_.point_of(o_), kAnyWidth, &l)) {
      return false;
    }
    Eigen::Map<Eigen::Vector2d>{residuals} = l.residual;
    if (jacobian != nullptr) {
      JacobianMap<2> J(jacobian);
      J.noalias() = l.by_pose * at_.pose_by_unknowns(o_);
      J.noalias() += l.by_point * at_.point_by_unknowns(o_);
    }
    return true;
  }

  BundleObservation o_;
  const MotionAndPoints& at_;
};

/// Residuals of the priors of shape and mass centre, in sigma.
class MotionPriorCost final : public ceres::SizedCostFunction<kPriorNumbers, kFreeBodyUnknowns> {
 public:
  explicit MotionPriorCost(const FreeBodyProblem& problem) {
    J_.setZero();
    J_.block<kShapeNumbers, kShapeNumbers>(0, kRotationUnknowns - kShapeNumbers)
        .diagonal()
        .setConstant(1.0 / problem.shape_sigma);
    J_.bottomRightCorner<3, 3>().diagonal().setConstant(1.0 / problem.mass_centre_sigma);
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::Matrix<double, kPriorNumbers, 1>>{residuals} =
        J_ * Eigen::Map<const FreeBodyVector>(parameters[0]);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      JacobianMap<kPriorNumbers>{jacobians[0]} = J_;
    }
    return true;
  }

 private:
  Eigen::Matrix<double, kPriorNumbers, kFreeBodyUnknowns> J_;
};

FreeBodyReport solve(const FreeBodyProblem& problem, const BundleOptions& options) {
  MotionAndPoints state(problem, options.cauchy_sigma);
  if (!state.pose()) {
    return {};
  }
  const double cost_before = state.cost();
  std::deque<FollowedPointCost> costs;  // they cannot be moved
  ceres::CauchyLoss loss(options.cauchy_sigma);
  MotionPriorCost prior(problem);
  ceres::Problem ceres(problem_options(&state));
  for (const BundleObservation& o : problem.bundle.observations) {
    costs.emplace_back(o, state);
    ceres.AddResidualBlock(&costs.back(), &loss, state.unknowns.data());
  }
  ceres.AddResidualBlock(&prior, nullptr, state.unknowns.data());
  ceres::Solver::Options of_solver = solver_options(options.iterations_max);
  of_solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  ceres::Solver::Summary summary;
  ceres::Solve(of_solver, &ceres, &summary);
  FreeBodyReport report{.bundle = report_of(summary)};
  report.bundle.cost_before = cost_before;  // Ceres's first one is that after settling
  report.bundle.usable = report.bundle.usable && state.pose();  // the last trial may not be kept
  if (report.bundle.usable) {
    report.information = state.information();
    *problem.motion = state.motion();
  }
  return report;
}

}  // namespace

FreeBodyReport adjust_free_body(const FreeBodyProblem& problem, const BundleOptions& options) {
  POLHODE_ASSERT(problem.times.size() == problem.bundle.poses.size(), problem.times.size());
  if (problem.bundle.observations.empty()) {
    return {};
  }
  const BundlePart part(problem.bundle, options.observations_max);
  FreeBodyProblem of_part = problem;
  of_part.bundle = part.problem();
  FreeBodyReport report = solve(of_part, options);
  if (report.bundle.usable) {
    part.put_back(options.cauchy_sigma);
  }
  return report;
}

}  // namespace polhode
