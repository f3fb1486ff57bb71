#include "motion/rigid_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"
#include "motion/body_dynamics.hpp"
#include "motion/residual_level.hpp"

namespace polhode {
namespace {

// Poses of a free body stay under this chi-square per degree of freedom where their sigmas are
// right to a fifth: 1.2^2 (decision 0051).
constexpr double kChi2PerDofMax = 1.4;
// Part of the poses. Chosen; with more outliers the rest may be of another motion.
constexpr double kOutliersMax = 0.3;
// Of the newest poses: one may be an outlier, from two on the motion has changed.
constexpr std::size_t kOutliersAtEndMax = 1;
// Sigma of the released prior: exp(15) as a ratio of moments is open, and yet a finite number.
constexpr double kReleasedShapeSigma = 10.0 * kModelShapeSigma;
// The logarithm of a vanishing moment is reached in steps of about one; its released sigma is 15.
constexpr int kReleasedIterationsMax = 60;

bool inverse_of(const Eigen::Matrix3d& covariance, Eigen::Matrix3d& information) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  information = llt.solve(Eigen::Matrix3d::Identity());
  return covariance.allFinite() && llt.info() == Eigen::Success && information.allFinite();
}

/// The poses as samples of both fits, with the covariance of noise and drift. False when one is not
/// usable.
bool load(std::span<const PoseSample> poses,
          const PoseCovariance& drift,
          std::int64_t reference_ns,
          MotionWorkspace& work) {
  work.attitudes.clear();
  work.positions.clear();
  for (const PoseSample& pose : poses) {
    const PoseCovariance total = pose.covariance + drift;
    AttitudeSample attitude{.time_s = seconds_between(reference_ns, pose.timestamp_ns),
                            .R_IT = pose.pose.R_CT,
                            .information_I = {}};
    PositionSample position{.time_s = attitude.time_s,
                            .p_I = pose.pose.p_CT,
                            .information_I = {},
                            .R_IT = pose.pose.R_CT};
    if (!inverse_of(total.topLeftCorner<3, 3>(), attitude.information_I) ||
        !inverse_of(total.bottomRightCorner<3, 3>(), position.information_I) ||
        !work.attitudes.push_back(attitude) || !work.positions.push_back(position)) {
      return false;
    }
  }
  return true;
}

/// Residual in sigmas as declared.
Eigen::Vector3d whitened(const Eigen::Vector3d& residual, const Eigen::Matrix3d& information) {
  return information.llt().matrixU() * residual;
}

/// Fitted attitudes with their derivatives at every sample, and the residuals.
bool trace(const RotationSolution& rotation,
           const RotationProblem& problem,
           MotionWorkspace& work) {
  const Inertia inertia = inertia_of(rotation.shape);
  work.residuals.clear();
  for (std::size_t i = 0; i < work.attitudes.size(); ++i) {
    (void)work.residuals.push_back(Eigen::Vector3d::Zero());
  }
  for (const bool forward : {true, false}) {
    RotationState state = rotation.reference;
    RotationDerivative derivative = RotationDerivative::at_reference();
    const std::size_t count =
        forward ? work.attitudes.size() - problem.reference : problem.reference;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = forward ? problem.reference + k : problem.reference - 1 - k;
      const AttitudeSample& sample = work.attitudes[i];
      if (!advance(inertia, problem.orbit, sample.time_s, state, &derivative)) {
        return false;
      }
      work.positions[i].R_IT = state.R_IT;
      work.positions[i].attitude_by_rotation_I = derivative.attitude_I;
      work.residuals[i] =
          whitened(so3_log(sample.R_IT * state.R_IT.transpose()), sample.information_I);
    }
  }
  return true;
}

double share_of(const Eigen::Matrix3d& drift, const Eigen::Matrix3d& total) {
  return total.trace() > 0.0 ? std::clamp(drift.trace() / total.trace(), 0.0, 1.0) : 0.0;
}

/// Share of the drift in the declared variances, and the rotation between poses.
ResidualInput residual_input(std::span<const PoseSample> poses,
                             const PoseCovariance& drift,
                             bool attitude,
                             const MotionWorkspace& work) {
  ResidualInput input{.residuals = work.residuals.view(),
                      .unknowns = attitude ? kRotationUnknowns : kTranslationUnknowns};
  const Eigen::Index corner = attitude ? 0 : 3;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Matrix3d of_drift = drift.block<3, 3>(corner, corner);
    const Eigen::Matrix3d of_pose = poses[i].covariance.block<3, 3>(corner, corner);
    input.drift_share += share_of(of_drift, of_drift + of_pose);
    if (i > 0) {
      input.rotation_of_frame_rad +=
          rotation_angle_rad(work.positions[i - 1].R_IT, work.positions[i].R_IT);
    }
  }
  input.drift_share /= static_cast<double>(poses.size());
  input.rotation_of_frame_rad /= static_cast<double>(std::max<std::size_t>(1, poses.size() - 1));
  return input;
}

template <typename Matrix>
Matrix widened_inverse(const Matrix& information, const Matrix& prior, double factor) {
  const Matrix total = (information - prior) / factor + prior;
  return total.ldlt().solve(Matrix::Identity());
}

void add_path(std::span<const PoseSample> poses,
              const KnownBody& prior_body,
              const MotionSnapshot& snapshot,
              MotionWorkspace& work,
              RigidModel& model) {
  const RotationCovariance rotation =
      model.covariance.topLeftCorner<kRotationUnknowns, kRotationUnknowns>();
  const TranslationProblem problem{.samples = work.positions.view(),
                                   .reference_s = 0.0,
                                   .orbit = model.orbit,
                                   .mass_centre_T = prior_body.mass_centre_T,
                                   .mass_centre_sigma = prior_body.mass_centre_sigma};
  const Result<TranslationSolution> solved = solve_translation(problem);
  if (!solved) {
    return;
  }
  const TranslationSolution& path = solved.value();
  for (std::size_t i = 0; i < work.positions.size(); ++i) {
    const PositionSample& sample = work.positions[i];
    const auto transition = translation_transition(model.orbit, 0.0, sample.time_s);
    const Eigen::Vector3d fitted =
        transition.topRows<3>() * path.unknowns.head<6>() - sample.R_IT * path.unknowns.tail<3>();
    work.residuals[i] = whitened(sample.p_I - fitted, sample.information_I);
  }
  model.position = residual_level(residual_input(poses, snapshot.drift, false, work));
  TranslationCovariance prior = TranslationCovariance::Zero();
  prior.diagonal().tail<3>() = prior_body.mass_centre_sigma.cwiseAbs2().cwiseInverse();
  const TranslationCovariance own =
      widened_inverse(path.information, prior, widening(model.position));
  model.path = path.unknowns;
  model.covariance.bottomLeftCorner<kTranslationUnknowns, kRotationUnknowns>() =
      path.by_rotation * rotation;
  model.covariance.topRightCorner<kRotationUnknowns, kTranslationUnknowns>() =
      (path.by_rotation * rotation).transpose();
  model.covariance.bottomRightCorner<kTranslationUnknowns, kTranslationUnknowns>() =
      own + path.by_rotation * rotation * path.by_rotation.transpose();
  model.translation_known = own.allFinite() && own.diagonal().minCoeff() > 0.0;
}

/// Residuals and covariance of a rotation. False, with a status, where the residuals refuse it.
bool take_rotation(const RotationSolution& rotation,
                   const RotationProblem& problem,
                   std::span<const PoseSample> poses,
                   const MotionSnapshot& snapshot,
                   MotionWorkspace& work,
                   RigidModel& model) {
  model.status = ModelStatus::kNoFit;
  if (!trace(rotation, problem, work)) {
    return false;
  }
  model.reference = rotation.reference;
  model.shape = rotation.shape;
  model.attitude = residual_level(residual_input(poses, snapshot.drift, true, work));
  const double outliers_max = kOutliersMax * static_cast<double>(poses.size());
  if (!(model.attitude.chi2_per_dof < kChi2PerDofMax) ||
      static_cast<double>(model.attitude.outliers) > outliers_max ||
      model.attitude.outliers_at_end > kOutliersAtEndMax) {
    model.status = ModelStatus::kResidualsTooLarge;
    return false;
  }
  RotationCovariance prior = RotationCovariance::Zero();
  prior.diagonal().tail<5>() = problem.prior.information();
  const RotationCovariance covariance =
      widened_inverse(rotation.information, prior, widening(model.attitude));
  if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() > 0.0)) {
    return false;
  }
  model.covariance.topLeftCorner<kRotationUnknowns, kRotationUnknowns>() = covariance;
  model.status = ModelStatus::kAccepted;
  return true;
}

/// Are the inertia ratios well determined by the poses, while the prior still moves the shape? This
/// occurs for sheets and thin rods: the prior moves a nearly vanishing second moment by several
/// sigmas.
bool prior_outlived(const RigidModel& model, const ShapePrior& prior) {
  // Relative sigma of the ratios, and sigmas of the shape (decision 0049).
  constexpr double kKnown = 0.01;
  constexpr double kMoved = 0.1;
  const InertiaShape pull = prior.information().cwiseProduct(model.shape - prior.mean);
  const double moved2 = pull.dot(model.covariance.block<5, 5>(6, 6) * pull);
  if (!(moved2 > kMoved * kMoved)) {
    return false;
  }
  const Result<BodyDynamics> body = describe_dynamics(model);
  const auto known = [](const Estimated& ratio) { return ratio.sigma < kKnown * ratio.value; };
  return body && known(body.value().middle_over_least) && known(body.value().largest_over_least);
}

/// The prior of an unknown body of this size.
KnownBody unknown_body(double body_radius) {
  return {.shape_sigma = InertiaShape::Constant(kModelShapeSigma),
          .mass_centre_sigma = Eigen::Vector3d::Constant(body_radius)};
}

RigidModel fit_window(std::span<const PoseSample> poses,
                      const KnownBody& prior,
                      const MotionSnapshot& snapshot,
                      MotionWorkspace& work) {
  RigidModel model;
  model.poses = poses.size();
  if (poses.size() < kModelPosesMin) {
    return model;
  }
  model.status = ModelStatus::kNoFit;
  const std::size_t middle = poses.size() / 2;
  model.reference_ns = poses[middle].timestamp_ns;
  model.span_s = seconds_between(poses.front().timestamp_ns, poses.back().timestamp_ns);
  model.orbit = orbit_at(snapshot.options, model.reference_ns);
  model.mass_centre_sigma = snapshot.body_radius;
  RotationProblem problem{.samples = {},
                          .reference = middle,
                          .orbit = model.orbit,
                          .prior = {.mean = prior.shape, .sigma = prior.shape_sigma}};
  if (!load(poses, snapshot.drift, model.reference_ns, work)) {
    return model;
  }
  problem.samples = work.attitudes.view();
  const Result<RotationSolution> found =
      fit_attitudes(problem, model.reference_ns, snapshot.previous);
  if (!found || !take_rotation(found.value(), problem, poses, snapshot, work, model)) {
    return model;
  }
  if (!prior.known && prior_outlived(model, problem.prior)) {
    problem.prior.sigma.setConstant(kReleasedShapeSigma);
    problem.iterations_max = kReleasedIterationsMax;
    const auto released = refine_rotation(problem, found.value(), 0, problem.samples.size());
    if (!released || !take_rotation(released.value(), problem, poses, snapshot, work, model)) {
      problem.prior.sigma = prior.shape_sigma;
      (void)take_rotation(found.value(), problem, poses, snapshot, work, model);
    }
  }
  add_path(poses, prior, snapshot, work, model);
  return model;
}

}  // namespace

Result<RotationSolution> fit_attitudes(const RotationProblem& problem,
                                       std::int64_t reference_ns,
                                       RigidModel previous) {
  if (move_reference(reference_ns, previous)) {
    RotationSolution solution;
    solution.reference = previous.reference;
    solution.shape = previous.shape;
    auto warm = refine_rotation(problem, solution, 0, problem.samples.size());
    if (warm && chi2_per_dof(warm.value()) < kChi2PerDofMax) {
      return warm;
    }
  }
  return solve_rotation(problem, kChi2PerDofMax);
}

Orbit orbit_at(const MotionOptions& options, std::int64_t reference_ns) {
  Orbit orbit;
  if (options.dynamics != DynamicsKind::kOrbit) {
    return orbit;
  }
  orbit.mean_motion_rad_s = options.mean_motion_rad_s;
  const Eigen::Quaterniond q_IH(options.q_IH_w, options.q_IH_x, options.q_IH_y, options.q_IH_z);
  orbit.R_IH = q_IH.normalized().toRotationMatrix();
  orbit.R_IH = orbit.R_IH_at(seconds_between(options.orbit_epoch_ns, reference_ns));
  return orbit;
}

RigidModel fit_rigid_model(const MotionSnapshot& snapshot, MotionWorkspace& workspace) {
  const std::span<const PoseSample> poses = snapshot.poses.view();
  if (snapshot.known_body.known) {
    RigidModel known = fit_window(poses, snapshot.known_body, snapshot, workspace);
    if (known.accepted() && move_reference(poses.back().timestamp_ns, known)) {
      return known;
    }
  }
  const KnownBody prior = unknown_body(snapshot.body_radius);
  RigidModel model = fit_window(poses, prior, snapshot, workspace);
  // A disturbance of the target may lie before the later half, or the later quarter.
  for (const std::size_t part : {2U, 4U}) {
    const std::size_t count = poses.size() / part;
    if (model.accepted() || count < 2 * kModelPosesMin) {
      break;
    }
    const RigidModel later = fit_window(poses.last(count), prior, snapshot, workspace);
    model = later.accepted() ? later : model;
  }
  if (model.accepted() && !move_reference(poses.back().timestamp_ns, model)) {
    model.status = ModelStatus::kNoFit;
  }
  return model;
}

}  // namespace polhode
