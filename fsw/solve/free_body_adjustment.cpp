#include "solve/free_body_adjustment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/assert.hpp"
#include "geometry/so3.hpp"
#include "solve/bundle_system.hpp"

namespace polhode {
namespace {

using ByUnknowns = FreeBodyWorkspace::ByUnknowns;
// Part of each unknown's own curvature. Where the linear model fails the first steps fail and it
// rises; a failed step costs a trial, but no new system. A larger one was worse:
// docs/decisions/0041.
constexpr double kDampingFirst = 1e-4;

using GaugeRows = Eigen::Matrix<double, 7, kFreeBodyUnknowns>;

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

class FreeBody {
 public:
  FreeBody(const FreeBodyProblem& problem,
           const BundleOptions& options,
           BundleWorkspace* workspace,
           FreeBodyWorkspace* own)
      : p_(problem), w_(*own), system_(problem.bundle, options.cauchy_sigma, workspace) {
    POLHODE_ASSERT(problem.times.size() == count(), problem.times.size());
    const auto order = std::span(w_.in_order_of_time).first(count());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return p_.times[a].time_s < p_.times[b].time_s;
    });
  }

  /// The poses by the motion. @return false where the integration fails or a pose lies behind the
  /// camera.
  bool pose(const FreeBodyMotion& motion, std::span<InverseDepthPose> poses) {
    return trace(
        motion, nullptr, [&](std::size_t k, const RotationState& state, const RotationDerivative&) {
          const auto R_CI = p_.times[k].R_IC.transpose();
          const Pose pose{.R_CT = R_CI * state.R_IT,
                          .p_CT = R_CI * place_of(motion, state, RotationJacobian::Zero()).p_I};
          const bool in_front = pose.p_CT.allFinite() && pose.p_CT.z() > 0.0;
          if (in_front) {
            poses[k] = to_inverse_depth(pose);
          }
          return in_front;
        });
  }

  double try_step(double damping) {
    if (!built_ && !build()) {
      return -1.0;
    }
    FreeBodyInformation damped = H_;
    damped.diagonal() += damping * curvature_;
    const Eigen::LLT<FreeBodyInformation> factor(damped);
    if (factor.info() != Eigen::Success) {
      return -1.0;
    }
    const FreeBodyVector x = factor.solve(right_);
    trial_ = moved(*p_.motion, x);
    if (!x.allFinite() || !pose(trial_, system_.trial_poses())) {
      return -1.0;
    }
    return x.dot(right_) - 0.5 * x.dot(H_ * x);
  }

  [[nodiscard]] double cost() const { return system_.cost() + prior_cost(*p_.motion); }
  double settle_trial() { return system_.settle_points() + prior_cost(trial_); }

  void keep_trial() {
    system_.keep_trial();
    *p_.motion = trial_;
    built_ = false;
  }

  FreeBodyInformation information() { return built_ || build() ? H_ : FreeBodyInformation::Zero(); }

 private:
  [[nodiscard]] std::size_t count() const { return p_.bundle.poses.size(); }

  /// The least cost over all points as a quadratic of the unknowns about the present motion.
  bool build() {
    // Damping of points that are seen without parallax; otherwise next to nothing.
    constexpr double kPointDamping = 1e-9;
    if (!linearise()) {
      return false;
    }
    system_.build(kPointDamping);
    H_ = project();
    right_ = -prior().cwiseProduct(unknowns_of(*p_.motion));
    const BundleSystem::Unknowns of_poses = system_.step();
    for (std::size_t k = 0; k < count(); ++k) {
      right_ += w_.pose_by_unknowns[k].transpose() *
                of_poses.segment<6>(6 * static_cast<Eigen::Index>(k));
    }
    H_.diagonal() += prior();
    curvature_ = H_.diagonal();
    // Sigma of the gauge, rad and parts of the extent: far below any sigma of the images, far above
    // rounding.
    constexpr double kGaugeSigma = 1e-6;
    const GaugeRows constraint = gauge() / kGaugeSigma;
    H_ += constraint.transpose() * constraint;
    built_ = true;
    return true;
  }

  /// Calls `take` for each pose with the state at its time, and with the derivatives if `begin` is
  /// given.
  template <typename Take>
  bool trace(const FreeBodyMotion& motion, const RotationDerivative* begin, Take take) {
    const Inertia inertia = inertia_of(motion.shape);
    const auto order = std::span(w_.in_order_of_time).first(count());
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

  bool linearise() {
    const RotationDerivative begin = RotationDerivative::at_reference();
    gauge_.setZero();
    return trace(
        *p_.motion,
        &begin,
        [&](std::size_t k, const RotationState& state, const RotationDerivative& by) {
          const Place place = place_of(*p_.motion, state, by.attitude_I);
          const auto R_CI = p_.times[k].R_IC.transpose();
          Eigen::Matrix<double, 3, kFreeBodyUnknowns> rotation;
          rotation << by.attitude_I, Eigen::Matrix<double, 3, kTranslationUnknowns>::Zero();
          w_.pose_by_unknowns[k] << R_CI * rotation,
              uvs_by_position(R_CI * place.p_I) * (R_CI * place.by_unknowns);
          gauge_.topRows<3>() += state.R_IT.transpose() * rotation;
          gauge_.middleRows<3>(3) +=
              state.R_IT.transpose() * place.by_unknowns / p_.mass_centre_sigma;
          gauge_.row(6) += place.p_I.transpose() * place.by_unknowns / place.p_I.squaredNorm();
          return true;
        });
  }

  /// T's rotation, shift (in the body's extent) and scale by the unknowns, mean over the poses.
  [[nodiscard]] GaugeRows gauge() const { return gauge_ / static_cast<double>(count()); }

  /// The reduced system of the poses in terms of the unknowns.
  FreeBodyInformation project() {
    const BundleSystem::Reduced S = system_.reduced();
    FreeBodyInformation H = FreeBodyInformation::Zero();
    for (std::size_t a = 0; a < count(); ++a) {
      const auto at = [](std::size_t k) { return 6 * static_cast<Eigen::Index>(k); };
      ByUnknowns row =
          S.block<6, 6>(at(a), at(a)).selfadjointView<Eigen::Lower>() * w_.pose_by_unknowns[a];
      row *= 0.5;  // the other half is its transpose
      for (std::size_t b = 0; b < a; ++b) {
        row.noalias() += S.block<6, 6>(at(a), at(b)) * w_.pose_by_unknowns[b];
      }
      H.noalias() += w_.pose_by_unknowns[a].transpose() * row;
    }
    return H + FreeBodyInformation(H.transpose());
  }

  [[nodiscard]] FreeBodyVector prior() const {
    FreeBodyVector information = FreeBodyVector::Zero();
    information.segment<5>(6).setConstant(1.0 / (p_.shape_sigma * p_.shape_sigma));
    information.tail<3>().setConstant(1.0 / (p_.mass_centre_sigma * p_.mass_centre_sigma));
    return information;
  }

  static FreeBodyVector unknowns_of(const FreeBodyMotion& motion) {
    FreeBodyVector unknowns;
    unknowns << Eigen::Vector3d::Zero(), motion.reference.w_T_rad_s, motion.shape, motion.path;
    return unknowns;
  }

  [[nodiscard]] double prior_cost(const FreeBodyMotion& motion) const {
    return 0.5 * prior().dot(unknowns_of(motion).cwiseAbs2());
  }

  static FreeBodyMotion moved(const FreeBodyMotion& motion, const FreeBodyVector& x) {
    FreeBodyMotion to = motion;
    to.reference.R_IT = so3_exp(x.head<3>()) * motion.reference.R_IT;
    to.reference.w_T_rad_s += x.segment<3>(3);
    to.shape += x.segment<5>(6);
    to.path += x.tail<kTranslationUnknowns>();
    return to;
  }

  const FreeBodyProblem& p_;
  FreeBodyWorkspace& w_;
  BundleSystem system_;
  FreeBodyMotion trial_;
  GaugeRows gauge_ = GaugeRows::Zero();
  bool built_ = false;  ///< the members below belong to the present motion
  FreeBodyInformation H_ = FreeBodyInformation::Zero();
  FreeBodyVector curvature_ =
      FreeBodyVector::Zero();                      ///< H's diagonal before the gauge is constrained
  FreeBodyVector right_ = FreeBodyVector::Zero();  ///< H x = right
};

}  // namespace

FreeBodyReport adjust_free_body(const FreeBodyProblem& problem,
                                const BundleOptions& options,
                                BundleWorkspace* workspace,
                                FreeBodyWorkspace* own) {
  FreeBody body(problem, options, workspace, own);
  FreeBodyReport report;
  if (problem.bundle.observations.empty() || !body.pose(*problem.motion, problem.bundle.poses)) {
    return report;
  }
  report.bundle = take_damped_steps(
      body.cost(),
      options.iterations_max,
      kDampingFirst,
      [&](double damping) { return body.try_step(damping); },
      [&] { return body.settle_trial(); },
      [&] { body.keep_trial(); });
  if (report.bundle.usable) {
    report.information = body.information();
  }
  return report;
}

}  // namespace polhode
