#include "solve/initial_adjustment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"
#include "geometry/so3.hpp"
#include "solve/initial_residuals.hpp"
#include "solve/small_fit.hpp"

namespace polhode {
namespace {

using Workspace = InitialAdjustmentWorkspace;

// Levenberg-Marquardt's damping, by factors of 10 (Marquardt 1963): the first value matters little.
// Above kDampingMax steps are too small to matter; under kDampingMin it has no effect.
constexpr double kDampingFirst = 1e-3;
constexpr double kDampingMin = 1e-9;
constexpr double kDampingMax = 1e8;
constexpr double kDampingUp = 10.0;
constexpr double kDampingDown = 0.1;
// Added to each diagonal element, as a part of the trace: an undetermined unknown stays finite. Far
// above rounding, far below information.
constexpr double kFloor = 1e-12;
// Least known points of a pose: three, and one that chooses among the solutions.
constexpr int kPointsMin = 4;

/// Adds one observation to the normal equations. An observation of a wrong track moves only its own
/// point.
void add_observation(const TrackObservation& s,
                     bool wrong,
                     const InitialGeometryView& geometry,
                     const InitialAdjustmentOptions& options,
                     Workspace::Block* block,
                     Workspace* w) {
  block->frame = -1;
  const auto frame = static_cast<std::size_t>(s.frame);
  const auto track = static_cast<std::size_t>(s.track);
  Eigen::Vector2d x;
  ReprojectionJacobians J;
  if (!usable(geometry, s) || !reproject(geometry.poses[frame], geometry.points_T[track], &x, &J)) {
    return;
  }
  const double inverse_sigma = 1.0 / (s.sigma_normalised * options.sigma_scale);
  const Eigen::Vector2d residual = inverse_sigma * (x - s.normalised);
  const double weight = initial_weight(residual.squaredNorm(), options);
  if (!(weight > 0.0)) {
    return;
  }
  const Eigen::Matrix<double, 2, 3> B = inverse_sigma * J.point;
  w->point_blocks[track].V.noalias() += weight * B.transpose() * B;
  w->point_blocks[track].g.noalias() += weight * B.transpose() * residual;
  if (wrong) {
    return;
  }
  if (options.rotations_fixed) {
    J.rotation.setZero();
  }
  Eigen::Matrix<double, 2, 6> A;
  A << inverse_sigma * J.rotation, inverse_sigma * J.uvs;
  const Eigen::Matrix<double, 6, 2> weighted = weight * A.transpose();
  block->frame = s.frame;
  block->W.noalias() = weighted * B;
  w->camera_blocks[frame].noalias() += weighted * A;
  w->camera_gradient.segment<6>(6 * s.frame).noalias() += weighted * residual;
}

/// Fixes attitudes, with a prior of a thousandth of the translations' sigma.
void fix_rotations(std::size_t frames, Workspace* w) {
  // ratio of variances
  constexpr double kKnown = 1e6;
  for (std::size_t f = 0; f < frames; ++f) {
    auto& U = w->camera_blocks[f];
    U.diagonal().head<3>().setConstant(kKnown * U.trace());
  }
}

/// Fills the camera, point and mixed blocks of the normal equations.
void linearise(std::span<const TrackObservation> observations,
               const InitialGeometryView& geometry,
               const InitialAdjustmentOptions& options,
               Workspace* w) {
  const std::size_t frames = geometry.poses.size();
  for (std::size_t f = 0; f < frames; ++f) {
    w->camera_blocks[f].setZero();
  }
  w->camera_gradient.setZero(static_cast<Eigen::Index>(6 * frames));
  w->point_blocks.resize(geometry.points_T.size());
  for (Workspace::PointBlock& block : w->point_blocks) {
    block.V.setZero();
    block.g.setZero();
  }
  w->blocks.resize(observations.size());
  for (std::size_t begin = 0; begin < observations.size();) {
    const std::size_t end = track_end(observations, begin);
    const std::span run = observations.subspan(begin, end - begin);
    const bool wrong =
        options.loss == InitialLoss::kTruncated && track_cost(run, geometry, options).wrong;
    for (std::size_t i = begin; i < end; ++i) {
      add_observation(observations[i], wrong, geometry, options, &w->blocks[i], w);
    }
    begin = end;
  }
  if (options.rotations_fixed) {
    fix_rotations(frames, w);
  }
}

/// Inverse of a point's damped block; zero for a point without weight.
Eigen::Matrix3d point_inverse(const Eigen::Matrix3d& V, double damping) {
  Eigen::Matrix3d damped = V;
  damped.diagonal() *= 1.0 + damping;
  const double floor = kFloor * V.trace();
  if (!(floor > 0.0)) {
    return Eigen::Matrix3d::Zero();
  }
  damped.diagonal().array() += floor;
  return damped.inverse();
}

/// Computes the reduced camera system S (lower triangle), with its right-hand side in camera_step.
void eliminate_points(std::span<const TrackObservation> observations,
                      double damping,
                      Workspace* w) {
  const Eigen::Index size = w->camera_gradient.size();
  w->reduced.setZero(size, size);
  w->camera_step = w->camera_gradient;
  for (Eigen::Index f = 0; f < size / 6; ++f) {
    Eigen::Matrix<double, 6, 6> U = w->camera_blocks[static_cast<std::size_t>(f)];
    // A frame without observations keeps its pose.
    const bool empty = !(U.trace() > 0.0);
    U.diagonal().array() *= 1.0 + damping;
    U.diagonal().array() += empty ? 1.0 : kFloor * U.trace();
    w->reduced.block<6, 6>(6 * f, 6 * f) = U;
  }
  for (std::size_t begin = 0; begin < observations.size();) {
    const std::size_t end = track_end(observations, begin);
    const Workspace::PointBlock& point =
        w->point_blocks[static_cast<std::size_t>(observations[begin].track)];
    const Eigen::Matrix3d V_inverse = point_inverse(point.V, damping);
    for (std::size_t i = begin; i < end; ++i) {
      const Workspace::Block& a = w->blocks[i];
      if (a.frame < 0) {
        continue;
      }
      const Eigen::Matrix<double, 6, 3> Y = a.W * V_inverse;
      w->camera_step.segment<6>(6 * a.frame).noalias() -= Y * point.g;
      for (std::size_t j = begin; j <= i; ++j) {
        const Workspace::Block& b = w->blocks[j];
        if (b.frame >= 0) {
          w->reduced.block<6, 6>(6 * a.frame, 6 * b.frame).noalias() -= Y * b.W.transpose();
        }
      }
    }
    begin = end;
  }
}

void apply_camera_step(const InitialGeometryView& geometry, Workspace* w) {
  for (std::size_t f = 0; f < geometry.poses.size(); ++f) {
    w->trial_poses[f] = geometry.poses[f];
    if (geometry.posed[f] != 0) {
      const auto step = w->camera_step.segment<6>(static_cast<Eigen::Index>(6 * f));
      w->trial_poses[f].R_CT = so3_exp(-step.head<3>()) * geometry.poses[f].R_CT;
      w->trial_poses[f].uvs -= step.tail<3>();
    }
  }
}

void apply_point_steps(std::span<const TrackObservation> observations,
                       const InitialGeometryView& geometry,
                       double damping,
                       Workspace* w) {
  std::copy(geometry.points_T.begin(), geometry.points_T.end(), w->trial_points.begin());
  for (std::size_t begin = 0; begin < observations.size();) {
    const std::size_t end = track_end(observations, begin);
    const auto track = static_cast<std::size_t>(observations[begin].track);
    Eigen::Vector3d g = w->point_blocks[track].g;
    for (std::size_t i = begin; i < end; ++i) {
      if (w->blocks[i].frame >= 0) {
        g.noalias() -=
            w->blocks[i].W.transpose() * w->camera_step.segment<6>(6 * w->blocks[i].frame);
      }
    }
    if (geometry.known[track] != 0) {
      w->trial_points[track] -= point_inverse(w->point_blocks[track].V, damping) * g;
    }
    begin = end;
  }
}

/// One damped step into the trial arrays. @return false when the system cannot be solved or a depth
/// would turn negative.
bool try_step(std::span<const TrackObservation> observations,
              const InitialGeometryView& geometry,
              double damping,
              Workspace* w) {
  with_avx2([&] { eliminate_points(observations, damping, w); });
  Eigen::Ref<Eigen::MatrixXd> S(w->reduced);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(S);
  if (factor.info() != Eigen::Success) {
    return false;
  }
  factor.solveInPlace(w->camera_step);
  if (!w->camera_step.allFinite()) {
    return false;
  }
  apply_camera_step(geometry, w);
  for (std::size_t f = 0; f < geometry.poses.size(); ++f) {
    if (geometry.posed[f] != 0 && !(w->trial_poses[f].uvs.z() > 0.0)) {
      return false;
    }
  }
  with_avx2([&] { apply_point_steps(observations, geometry, damping, w); });
  return true;
}

/// Equations of a single pose. Unknowns: phi and the change of uvs, from the initial pose.
using PoseEquations = SmallEquations<6>;

InverseDepthPose moved(const InverseDepthPose& start, const PoseEquations::Vector& by) {
  return {.R_CT = so3_exp(by.head<3>()) * start.R_CT, .uvs = start.uvs + by.tail<3>()};
}

/// With the Cauchy loss, whatever the options.
PoseEquations linearise_pose(std::span<const TrackObservation> observations,
                             const InitialGeometryView& geometry,
                             const InitialAdjustmentOptions& options,
                             const InverseDepthPose& pose) {
  PoseEquations n;
  CauchySum cost(options.width_sigma);
  for (const TrackObservation& s : observations) {
    const auto track = static_cast<std::size_t>(s.track);
    Eigen::Vector2d x;
    ReprojectionJacobians J;
    if (geometry.known[track] == 0) {
      continue;
    }
    if (!reproject(pose, geometry.points_T[track], &x, &J)) {
      cost.add(behind_error2(options));
      continue;
    }
    const double inverse_sigma = 1.0 / (s.sigma_normalised * options.sigma_scale);
    const Eigen::Vector2d residual = inverse_sigma * (x - s.normalised);
    const double error2 = residual.squaredNorm();
    const double weight = cauchy_weight(error2, options.width_sigma);
    Eigen::Matrix<double, 2, 6> A;
    A << inverse_sigma * J.rotation, inverse_sigma * J.uvs;
    const Eigen::Matrix<double, 6, 2> weighted = weight * A.transpose();
    n.H.noalias() += weighted * A;
    n.g.noalias() += weighted * residual;
    cost.add(error2);
  }
  n.cost = cost.value();
  return n;
}

}  // namespace

bool reduced_camera_system(std::span<const TrackObservation> observations,
                           const InitialGeometryView& geometry,
                           const InitialAdjustmentOptions& options,
                           Workspace* workspace) {
  linearise(observations, geometry, options, workspace);
  eliminate_points(observations, 0.0, workspace);
  return workspace->reduced.allFinite();
}

InitialFit adjust_initial(std::span<const TrackObservation> observations,
                          const InitialGeometryView& geometry,
                          const InitialAdjustmentOptions& options,
                          Workspace* workspace) {
  POLHODE_ASSERT(observations.size() <= Workspace::kInitialObservations, observations.size());
  POLHODE_ASSERT(geometry.poses.size() <= limits::kInitialFrames, geometry.poses.size());
  POLHODE_ASSERT(geometry.points_T.size() <= limits::kInitialTracks, geometry.points_T.size());
  double damping = kDampingFirst;
  double cost = total_cost(observations, geometry.poses, geometry.points_T, geometry, options);
  int iteration = 0;
  bool stale = true;
  for (; iteration < options.iterations_max && damping < kDampingMax; ++iteration) {
    if (stale) {
      with_avx2([&] { linearise(observations, geometry, options, workspace); });
    }
    stale = false;
    if (!try_step(observations, geometry, damping, workspace)) {
      damping *= kDampingUp;
      continue;
    }
    const double next =
        total_cost(observations,
                   workspace->trial_poses,
                   std::span(workspace->trial_points).first(geometry.points_T.size()),
                   geometry,
                   options);
    if (!(next < cost)) {
      if (next - cost < options.settled) {
        break;  // equal to rounding
      }
      damping *= kDampingUp;
      continue;
    }
    std::copy_n(workspace->trial_poses.begin(), geometry.poses.size(), geometry.poses.begin());
    std::copy_n(
        workspace->trial_points.begin(), geometry.points_T.size(), geometry.points_T.begin());
    const bool settled = cost - next < options.settled;
    cost = next;
    stale = true;
    damping = std::max(kDampingMin, damping * kDampingDown);
    if (settled) {
      break;
    }
  }
  InitialFit fit = evaluate_initial(observations, geometry, options, workspace);
  fit.iterations = iteration;
  return fit;
}

double adjust_single_pose(std::span<const TrackObservation> observations,
                          const InitialGeometryView& geometry,
                          const InitialAdjustmentOptions& options,
                          InverseDepthPose* pose) {
  const auto known = std::count_if(
      observations.begin(), observations.end(), [&](const TrackObservation& observation) {
        return geometry.known[static_cast<std::size_t>(observation.track)] != 0;
      });
  if (known < kPointsMin) {
    return -1.0;
  }
  const InverseDepthPose start = *pose;
  PoseEquations::Vector by = PoseEquations::Vector::Zero();
  PoseEquations at_minimum;
  const int steps = minimise(
      [&](const PoseEquations::Vector& by_trial, PoseEquations* at) {
        const InverseDepthPose trial = moved(start, by_trial);
        *at = linearise_pose(observations, geometry, options, trial);
        return trial.uvs.z() > 0.0;
      },
      {.steps_max = options.iterations_max, .first_three = FirstThree::kRotation},
      &by,
      &at_minimum);
  *pose = moved(start, by);
  return steps < 0 ? -1.0 : at_minimum.cost;  // as without known points: it cannot be evaluated
}

}  // namespace polhode
