#include "initialisation/at_rest.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

Eigen::Matrix3d attitude_of_camera(const InitialProblem& problem, std::size_t frame) {
  return problem.R_IC.empty() ? Eigen::Matrix3d::Identity() : problem.R_IC[frame];
}

std::size_t middle_of(const InitialHypothesis& h) {
  std::size_t middle = h.frames / 2;
  while (middle > 0 && h.posed[middle] == 0) {
    --middle;
  }
  return middle;
}

/// All attitudes follow from the one in the middle of the hypothesis' frames by a steady rate.
void fix_attitude(const InitialProblem& problem,
                  const Eigen::Vector3d& rate_I_rad_s,
                  InitialHypothesis* h) {
  const std::size_t middle = middle_of(*h);
  const Eigen::Matrix3d R_IT = attitude_of_camera(problem, middle) * h->poses[middle].R_CT;
  for (std::size_t f = 0; f < h->frames; ++f) {
    const double time_s = problem.times_s[f] - problem.times_s[middle];
    h->poses[f].R_CT =
        attitude_of_camera(problem, f).transpose() * so3_exp(time_s * rate_I_rad_s) * R_IT;
  }
}

// Rate, and (u, v, s) of each frame.
constexpr int kSteadyUnknowns = 3 + 3 * static_cast<int>(limits::kInitialFrames);
using SteadyVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kSteadyUnknowns, 1>;
using SteadyMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kSteadyUnknowns, kSteadyUnknowns>;

/// Newton's step of the rate [rad/s], with positions and points eliminated; zero where there is
/// none.
Eigen::Vector3d step_of_rate(const Selection& c,
                             const Eigen::Vector3d& rate_I_rad_s,
                             InitialWorkspace* workspace,
                             InitialHypothesis* h) {
  constexpr double kDamping = 1e-6;  // relative; it fixes the gauge
  InitialAdjustmentWorkspace& w = workspace->adjustment;
  const std::span observations = workspace->set.observations.view();
  if (!reduced_camera_system(observations, h->view(), selection_loss(c, 0), &w)) {
    return Eigen::Vector3d::Zero();
  }
  const double middle_s = c.problem.times_s[middle_of(*h)];
  const auto turn_by_rate = [&](std::size_t f) -> Eigen::Matrix3d {
    const double time_s = c.problem.times_s[f] - middle_s;
    return time_s * attitude_of_camera(c.problem, f).transpose() *
           so3_left_jacobian(time_s * rate_I_rad_s);
  };
  const auto unknowns = static_cast<Eigen::Index>(3 + 3 * h->frames);
  SteadyMatrix N = SteadyMatrix::Zero(unknowns, unknowns);
  SteadyVector g = SteadyVector::Zero(unknowns);
  for (std::size_t f = 0; f < h->frames; ++f) {
    const auto row = static_cast<Eigen::Index>(3 * f);
    const Eigen::Matrix3d A = turn_by_rate(f);
    g.head<3>() += A.transpose() * w.camera_step.segment<3>(2 * row);
    g.segment<3>(3 + row) = w.camera_step.segment<3>(2 * row + 3);
    for (std::size_t other = 0; other <= f; ++other) {
      const auto col = static_cast<Eigen::Index>(3 * other);
      const Eigen::Matrix<double, 6, 6> S = w.reduced.block<6, 6>(2 * row, 2 * col);
      const Eigen::Matrix3d B = turn_by_rate(other);
      const Eigen::Matrix3d of_rate = A.transpose() * S.topLeftCorner<3, 3>() * B;
      N.block<3, 3>(3 + row, 3 + col) = S.bottomRightCorner<3, 3>();
      N.block<3, 3>(3 + row, 0) += S.bottomLeftCorner<3, 3>() * B;
      N.topLeftCorner<3, 3>() += of_rate;
      if (other != f) {
        N.block<3, 3>(3 + col, 0) += S.topRightCorner<3, 3>().transpose() * A;
        N.topLeftCorner<3, 3>() += of_rate.transpose();
      }
    }
  }
  N.diagonal() *= 1.0 + kDamping;
  const SteadyVector step = N.ldlt().solve(g);  // from its lower triangle
  return step.allFinite() ? Eigen::Vector3d(-step.head<3>()) : Eigen::Vector3d::Zero();
}

/// Lowest cost of a body that rotates at a constant rate. @param steady  in: the body at rest; out:
/// the rotating one.
double cost_of_steady(const Selection& free,
                      const Selection& held,
                      InitialWorkspace* w,
                      InitialHypothesis* steady) {
  constexpr int kSteps = 4;  // each is followed by a full adjustment; two or three settle
  InitialHypothesis& trial = w->finalists[0];
  Eigen::Vector3d rate_I_rad_s = Eigen::Vector3d::Zero();
  for (int i = 0; i < kSteps; ++i) {
    trial = *steady;
    const Eigen::Vector3d next = rate_I_rad_s + step_of_rate(free, rate_I_rad_s, w, &trial);
    fix_attitude(free.problem, next, &trial);
    if (!refine_to_minimum(held, w->set.observations.view(), &w->adjustment, &trial) ||
        !(trial.fit.cost < steady->fit.cost)) {
      break;
    }
    *steady = trial;
    rate_I_rad_s = next;
  }
  return steady->fit.cost;
}

}  // namespace

double compare_at_rest(Selection* c, InitialWorkspace* w) {
  InitialHypothesis& winner = w->refined[0];
  InitialHypothesis& at_rest = w->at_rest;
  Selection held = *c;
  held.rotations_fixed = true;
  at_rest = winner;
  fix_attitude(c->problem, Eigen::Vector3d::Zero(), &at_rest);
  if (!refine_to_minimum(held, w->set.observations.view(), &w->adjustment, &at_rest)) {
    return -std::numeric_limits<double>::infinity();
  }
  constexpr int kRotation = 3;  // unknowns
  const double of_unknown = std::log(2.0 * static_cast<double>(winner.fit.observations));
  const double noise = std::max(1.0, winner.fit.noise_scale);
  const double margin = kRotation * (winner.fit.frames - 1) * of_unknown -
                        (at_rest.fit.cost - winner.fit.cost) / (noise * noise);
  if (!(margin > 0.0)) {
    return margin;
  }
  // The penalty on free rotation's many unknowns favours rest too much. A constant rate has three
  // only.
  w->finalists.resize(2);
  InitialHypothesis& steady = w->finalists[1];
  steady = at_rest;
  const double against_steady =
      kRotation * of_unknown -
      (at_rest.fit.cost - cost_of_steady(*c, held, w, &steady)) / (noise * noise);
  if (!(against_steady > 0.0)) {
    return 0.0;
  }
  winner = at_rest;
  c->rotations_fixed = true;
  return margin;
}

}  // namespace polhode
