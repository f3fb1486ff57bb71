#include "motion/joint_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/assert.hpp"
#include "geometry/so3.hpp"
#include "motion/residual_level.hpp"
#include "solve/absolute_pose.hpp"
#include "solve/bundle_adjustment.hpp"

namespace polhode {
namespace {

// Free poses gain over bound ones by following the noise: a chi-square of 1 for each additional
// degree of freedom, were errors independent and of the declared size. On rendered scenes free
// bodies stay under 8, times off by a fifth of a frame give 11 and more (decision 0044).
constexpr double kGainPerDofMax = 8.0;

// Least share of the observations consistent with free poses that the joint fit keeps. The gain
// counts only the kept ones, so it does not show the rejected ones. Free bodies keep 0.976 and
// more, a camera or a table that moves by hand 0.3 to 0.5 (decision 0069).
constexpr double kKeptMin = 0.95;

// A map that has grown without the motion has wrong associations that agree with its drift. They
// contradict the motion until one joint fit has removed them: gains of up to 28, then 2 to 6. So a
// gain up to 40 is marginally accepted twice. Times that are made up give 60 and more
// (decision 0044).
constexpr double kMarginalGainMax = 40.0;
constexpr std::uint32_t kMarginalFitsMax = 2;

// Errors beyond the declared ones come from surfaces, as light slides over a relief, and from
// drift. Poses of one visible face share them, and the motion follows part of them. Free poses show
// 0.3 to 0.5 of a drift in their gain, so the gain over one counts twice (decision 0046).
constexpr double kDriftShown = 0.5;

// Drift of the poses that the first fit, to the poses alone, allows for: 1 deg, 1 % of the range.
// Chosen: equal weights, and the fit to the images follows.
constexpr double kPoseSigma_rad = 0.02;
constexpr double kPoseSigmaOfRange = 0.01;

// Width of the first loss, in sigmas: residuals of drifted poses. Chosen; narrower loses
// observations that agree once the poses have moved.
constexpr double kWide_sigmas = 15.0;
// Steps of the whole fit, in those of an ordinary adjustment. A fit solves 3 to 4 systems in the
// mean, more before half a rotation has been seen (decision 0043).
constexpr int kIterationsFactor = 4;
// Two steps reach 0.99 of the gain (decision 0044); more would not change the decision.
constexpr int kGainIterations = 2;
// Points that connect two poses: as many as a pose needs (decision 0045).
constexpr std::size_t kSharedMin = 12;

std::size_t count_of(const JointFitInput& input) { return input.bundle.poses.size(); }

std::span<const std::size_t> order_by_time(const JointFitInput& input, JointFitWorkspace* w) {
  const auto order = std::span(w->in_order_of_time).first(count_of(input));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return input.timestamps_ns[a] < input.timestamps_ns[b];
  });
  return order;
}

void load(const JointFitInput& input,
          std::span<const std::size_t> order,
          std::int64_t reference_ns,
          JointFitWorkspace* w) {
  w->attitudes.clear();
  w->positions.clear();
  for (const std::size_t k : order) {
    const Pose pose = turned(input.R_IC[k], from_inverse_depth(input.bundle.poses[k]));
    const double time_s = seconds_between(reference_ns, input.timestamps_ns[k]);
    w->times[k] = {.time_s = time_s, .R_IC = input.R_IC[k]};
    const double sigma_mu = kPoseSigmaOfRange * pose.p_CT.norm();
    (void)w->attitudes.push_back(
        {.time_s = time_s,
         .R_IT = pose.R_CT,
         .information_I = Eigen::Matrix3d::Identity() / (kPoseSigma_rad * kPoseSigma_rad)});
    (void)w->positions.push_back(
        {.time_s = time_s,
         .p_I = pose.p_CT,
         .information_I = Eigen::Matrix3d::Identity() / (sigma_mu * sigma_mu),
         .R_IT = pose.R_CT});
  }
}

/// Replaces the attitudes of the position samples by those of the motion.
bool trace(const RotationProblem& problem, const RotationSolution& rotation, JointFitWorkspace* w) {
  const Inertia inertia = inertia_of(rotation.shape);
  const auto propagate = [&](std::size_t first, std::size_t last, bool forward) {
    RotationState state = rotation.reference;
    for (std::size_t n = 0; n < last - first; ++n) {
      PositionSample& sample = w->positions[forward ? first + n : last - 1 - n];
      if (!advance(inertia, problem.orbit, sample.time_s, state, nullptr)) {
        return false;
      }
      sample.R_IT = state.R_IT;
    }
    return true;
  };
  return propagate(problem.reference, w->positions.size(), true) &&
         propagate(0, problem.reference, false);
}

std::optional<FreeBodyMotion> motion_of_poses(const JointFitInput& input,
                                              const RigidModel& model,
                                              std::size_t reference,
                                              JointFitWorkspace* w) {
  const RotationProblem problem{.samples = w->attitudes.view(),
                                .reference = reference,
                                .orbit = model.orbit,
                                .prior = {.sigma = InertiaShape::Constant(kModelShapeSigma)}};
  const auto rotation = fit_attitudes(problem, model.reference_ns, input.previous);
  if (!rotation || !trace(problem, rotation.value(), w)) {
    return std::nullopt;
  }
  const auto path =
      solve_translation({.samples = w->positions.view(),
                         .reference_s = 0.0,
                         .orbit = model.orbit,
                         .mass_centre_sigma = Eigen::Vector3d::Constant(input.body_radius)});
  if (!path) {
    return std::nullopt;
  }
  return FreeBodyMotion{.reference = rotation.value().reference,
                        .shape = rotation.value().shape,
                        .path = path.value().unknowns,
                        .orbit = model.orbit};
}

/// Adjusts the points to the poses, then all together, with a wide loss and then a narrow one.
/// Poses that have drifted give residuals of many sigma.
FreeBodyReport adjust(const JointFitInput& input, FreeBodyMotion* motion, JointFitWorkspace* w) {
  const FreeBodyProblem problem{.bundle = input.bundle,
                                .times = std::span(w->times).first(count_of(input)),
                                .motion = motion,
                                .shape_sigma = kModelShapeSigma,
                                .mass_centre_sigma = input.body_radius};
  BundleOptions options = input.options;
  options.iterations_max *= kIterationsFactor;
  options.cauchy_sigma = kWide_sigmas;
  FreeBodyReport report = adjust_free_body(problem, options);
  if (report.bundle.usable) {
    options.cauchy_sigma = input.options.cauchy_sigma;
    report = adjust_free_body(problem, options);
  }
  return report;
}

void keep(const BundleProblem& bundle, BundleCopy* copy) {
  std::copy(bundle.poses.begin(), bundle.poses.end(), copy->poses.begin());
  std::copy(bundle.points_T.begin(), bundle.points_T.end(), copy->points_T.begin());
}

void restore(const BundleCopy& copy, const BundleProblem& bundle) {
  std::copy_n(copy.poses.begin(), bundle.poses.size(), bundle.poses.begin());
  std::copy_n(copy.points_T.begin(), bundle.points_T.size(), bundle.points_T.begin());
}

bool agrees(const BundleProblem& bundle, const BundleObservation& o) {
  Eigen::Vector2d x;
  return reproject(bundle.poses[static_cast<std::size_t>(o.pose)],
                   bundle.points_T[static_cast<std::size_t>(o.point)],
                   &x) &&
         (x - o.normalised).squaredNorm() < kInlierChi2 * o.sigma_normalised * o.sigma_normalised;
}

std::size_t agreeing(const BundleProblem& bundle) {
  return static_cast<std::size_t>(std::count_if(
      bundle.observations.begin(), bundle.observations.end(), [&](const BundleObservation& o) {
        return agrees(bundle, o);
      }));
}

/// What free poses gain over the joint fit, per additional degree of freedom, on the observations
/// that agree with the fit.
double gain_per_dof(const JointFitInput& input, JointFitWorkspace* w) {
  BundleProblem problem = input.bundle;
  const auto end = std::stable_partition(
      input.observations.begin(), input.observations.end(), [&](const BundleObservation& o) {
        return agrees(problem, o);
      });
  problem.observations =
      input.observations.first(static_cast<std::size_t>(end - input.observations.begin()));
  keep(problem, &w->joint);
  BundleOptions options = input.options;
  options.iterations_max = kGainIterations;
  const BundleReport free = adjust_bundle(problem, options);
  restore(w->joint, problem);
  const double dof = 6.0 * static_cast<double>(count_of(input)) - kFreeBodyUnknowns;
  return 2.0 * (free.cost_before - free.cost_after) / dof;
}

using PoseFlags = std::array<bool, BundleLimits::kPoses>;
using PoseCounts = std::array<std::size_t, BundleLimits::kPoses>;

/// For each pose that is not reached: how many of its points at least `seen_min` poses observe,
/// counted among those that are reached or among those that are not.
PoseCounts shared_points(const JointFitInput& input,
                         const PoseFlags& reached,
                         bool with_reached,
                         int seen_min,
                         JointFitWorkspace* w) {
  w->observations_of_point.fill(0);
  for (const BundleObservation& o : input.observations) {
    if (reached[static_cast<std::size_t>(o.pose)] == with_reached) {
      ++w->observations_of_point[static_cast<std::size_t>(o.point)];
    }
  }
  PoseCounts shared{};
  for (const BundleObservation& o : input.observations) {
    const bool seen = w->observations_of_point[static_cast<std::size_t>(o.point)] >= seen_min;
    shared[static_cast<std::size_t>(o.pose)] +=
        seen && !reached[static_cast<std::size_t>(o.pose)] ? 1 : 0;
  }
  return shared;
}

/// Are the poses one part, connected by shared points? Separate parts have axes and a unit each, so
/// no image determines the distance between them. A single pose that has lost its associations is
/// not a part: the motion constrains it (decision 0045).
bool is_connected(const JointFitInput& input, JointFitWorkspace* w) {
  const std::size_t count = count_of(input);
  PoseFlags reached{};
  const PoseCounts points = shared_points(input, reached, false, 1, w);
  const auto most = std::max_element(points.begin(), points.end());
  reached[static_cast<std::size_t>(most - points.begin())] = true;
  std::size_t reached_count = 1;
  for (std::size_t before = 0; before < reached_count;) {
    before = reached_count;
    const PoseCounts shared = shared_points(input, reached, true, 1, w);
    for (std::size_t k = 0; k < count; ++k) {
      if (!reached[k] && shared[k] >= kSharedMin) {
        reached[k] = true;
        ++reached_count;
      }
    }
  }
  const PoseCounts apart = shared_points(input, reached, false, 2, w);
  return reached_count >= kModelPosesMin &&
         *std::max_element(apart.begin(), apart.end()) < kSharedMin;
}

/// Mean rotation from one keyframe to the next.
double rotation_of_keyframe(const JointFitInput& input, std::span<const std::size_t> order) {
  double rotation_rad = 0.0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const auto R_IT = [&](std::size_t k) {
      return Eigen::Matrix3d(input.R_IC[k] * input.bundle.poses[k].R_CT);
    };
    rotation_rad += rotation_angle_rad(R_IT(order[i - 1]), R_IT(order[i]));
  }
  return rotation_rad / static_cast<double>(order.size() - 1);
}

void take(const FreeBodyMotion& motion,
          const FreeBodyReport& report,
          const ResidualLevel& noise,
          double widening,
          RigidModel* model) {
  model->reference = motion.reference;
  model->shape = motion.shape;
  model->path = motion.path;
  model->attitude = noise;
  model->position = noise;
  const ModelCovariance covariance =
      widening * report.information.ldlt().solve(FreeBodyInformation::Identity());
  model->covariance = 0.5 * (covariance + covariance.transpose());
  const bool usable = covariance.allFinite() && covariance.diagonal().minCoeff() > 0.0;
  model->translation_known = usable;
  model->of_map = usable;
  model->status = usable ? ModelStatus::kAccepted : ModelStatus::kNoFit;
}

}  // namespace

RigidModel fit_jointly(const JointFitInput& input,
                       std::uint32_t* marginal_fits,
                       JointFitWorkspace* w) {
  POLHODE_ASSERT(input.timestamps_ns.size() == count_of(input), input.timestamps_ns.size());
  POLHODE_ASSERT(input.R_IC.size() == count_of(input), input.R_IC.size());
  RigidModel model;
  model.poses = count_of(input);
  if (model.poses < kModelPosesMin) {
    return model;
  }
  model.status = ModelStatus::kNoFit;
  const std::span<const std::size_t> order = order_by_time(input, w);
  if (!is_connected(input, w)) {
    return model;
  }
  const std::size_t middle = order.size() / 2;
  model.reference_ns = input.timestamps_ns[order[middle]];
  model.span_s =
      seconds_between(input.timestamps_ns[order.front()], input.timestamps_ns[order.back()]);
  model.orbit = orbit_at(input.motion, model.reference_ns);
  model.mass_centre_sigma = input.body_radius;
  load(input, order, model.reference_ns, w);
  std::optional<FreeBodyMotion> motion = motion_of_poses(input, model, middle, w);
  if (!motion) {
    return model;
  }
  keep(input.bundle, &w->free);
  const auto before = static_cast<double>(std::max<std::size_t>(1, agreeing(input.bundle)));
  const FreeBodyReport report = adjust(input, &*motion, w);
  if (report.bundle.usable) {
    const double kept = static_cast<double>(agreeing(input.bundle)) / before;
    const double gain = gain_per_dof(input, w);
    const double gain_max = *marginal_fits < kMarginalFitsMax ? kMarginalGainMax : kGainPerDofMax;
    model.status = ModelStatus::kResidualsTooLarge;
    model.attitude.chi2_per_dof = gain;
    if (kept > kKeptMin && gain < gain_max) {
      const ResidualLevel noise{
          .chi2_per_dof = gain,
          .scale2 = 1.0 + std::max(0.0, gain - 1.0) / kDriftShown,
          .correlation = poses_of_a_face(rotation_of_keyframe(input, order), order.size())};
      take(*motion, report, noise, input.selection * widening(noise), &model);
    }
  }
  if (model.accepted() && !move_reference(input.timestamps_ns[order.back()], model)) {
    model.status = ModelStatus::kNoFit;
  }
  if (model.accepted()) {
    *marginal_fits = model.attitude.chi2_per_dof < kGainPerDofMax ? 0 : *marginal_fits + 1;
  } else {
    restore(w->free, input.bundle);
  }
  return model;
}

RigidModel transformed(const RigidModel& model, const Similarity& b_of_a) {
  RigidModel to = model;
  const Eigen::Matrix3d& R = b_of_a.R_ba;
  Eigen::Matrix<double, 5, 5> shape;
  for (int k = 0; k < 5; ++k) {
    for (int j = 0; j < 5; ++j) {
      shape(j, k) = shape_basis(j).cwiseProduct(R * shape_basis(k) * R.transpose()).sum();
    }
  }
  ModelCovariance by = ModelCovariance::Identity();
  by.block<3, 3>(3, 3) = R;
  by.block<5, 5>(6, 6) = shape;
  by.block<6, 6>(kRotationUnknowns, kRotationUnknowns) *= b_of_a.scale;
  by.bottomRightCorner<3, 3>() = b_of_a.scale * R;
  to.reference.R_IT = model.reference.R_IT * R.transpose();
  to.reference.w_T_rad_s = R * model.reference.w_T_rad_s;
  to.shape = shape * model.shape;
  to.path.head<6>() *= b_of_a.scale;
  to.path.tail<3>() = b_of_a.apply(model.path.tail<3>());
  to.mass_centre_sigma *= b_of_a.scale;
  to.covariance = by * model.covariance * by.transpose();
  return to;
}

}  // namespace polhode
