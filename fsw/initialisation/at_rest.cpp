#include "initialisation/at_rest.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polhode {
namespace {

Eigen::Matrix3d attitude_of_camera(const StartProblem& problem, std::size_t frame) {
  return problem.R_IC.empty() ? Eigen::Matrix3d::Identity() : problem.R_IC[frame];
}

/// All attitudes are the one in the middle of the hypothesis' frames.
void hold_attitude(const StartProblem& problem, StartHypothesis* h) {
  std::size_t middle = h->frames / 2;
  while (middle > 0 && h->posed[middle] == 0) {
    --middle;
  }
  const Eigen::Matrix3d R_IT = attitude_of_camera(problem, middle) * h->poses[middle].R_CT;
  for (std::size_t f = 0; f < h->frames; ++f) {
    h->poses[f].R_CT = attitude_of_camera(problem, f).transpose() * R_IT;
  }
}

}  // namespace

double compare_at_rest(Selection* c) {
  StartHypothesis& winner = c->w.refined[0];
  StartHypothesis& at_rest = c->w.at_rest;
  Selection held = *c;
  held.rotations_held = true;
  at_rest = winner;
  hold_attitude(c->problem, &at_rest);
  if (!refine_to_minimum(held, c->w.set.observations.view(), &at_rest)) {
    return -std::numeric_limits<double>::infinity();
  }
  constexpr int kRotation = 3;  // unknowns
  const double saved = kRotation * (winner.fit.frames - 1) *
                       std::log(2.0 * static_cast<double>(winner.fit.observations));
  const double noise = std::max(1.0, winner.fit.noise_scale);
  const double evidence = saved - (at_rest.fit.cost - winner.fit.cost) / (noise * noise);
  if (evidence > 0.0) {
    winner = at_rest;
    c->rotations_held = true;
  }
  return evidence;
}

}  // namespace polhode
