#include "initialisation/initialise.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "initialisation/selection.hpp"

namespace polhode {
namespace {

// Depths of a body spread by some 0.6 extents: a fifth of that is then 2 sigma off. The
// adjustments that follow the commit bring it down.
constexpr double kDepthSigmaMax = 0.06;
// Tracks go wrong in 5 to 20 % of cases, and take their sightings with them; on a body of a hundred
// pixels that turns by 6 deg a frame in twice as many. A wrong hypothesis that explains half of the
// sightings is told by the gap, not by this.
constexpr double kInlierRatioMin = 0.5;

StartDecision decide(const StartOutcome& out, const StartOptions& options, double noise_scale) {
  if (out.inlier_ratio < kInlierRatioMin || noise_scale > kNoiseScaleMax) {
    return StartDecision::kNoHypothesis;
  }
  if (!(out.contest_depth_sigma < kDepthSigmaMax)) {
    return StartDecision::kTooLittleMotion;
  }
  const bool clear = out.chi2_gap >= options.chi2_gap_commit;
  const bool likely = out.chi2_gap >= options.chi2_gap_convexity && out.convexity >= kConvexityMin;
  return clear || likely ? StartDecision::kCommit : StartDecision::kTwinsTooClose;
}

}  // namespace

double convexity_cue(std::span<const StartSighting> sightings,
                     int frame,
                     const StartGeometryView& geometry) {
  if (geometry.posed[static_cast<std::size_t>(frame)] == 0) {
    return 0.0;
  }
  const InverseDepthPose& pose = geometry.poses[static_cast<std::size_t>(frame)];
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  double zz = 0.0;
  int count = 0;
  for (const StartSighting& s : sightings) {
    const auto track = static_cast<std::size_t>(s.track);
    if (s.frame != frame || geometry.known[track] == 0 || geometry.points_T[track].norm() > 4.0) {
      continue;
    }
    const Eigen::Vector3d q = pose.R_CT * geometry.points_T[track];
    const Eigen::Vector4d row(1.0, q.x(), q.y(), q.head<2>().squaredNorm());
    H += row * row.transpose();
    g += row * q.z();
    zz += q.z() * q.z();
    ++count;
  }
  if (count < 8) {
    return 0.0;
  }
  const Eigen::Vector4d fit = H.ldlt().solve(g);
  // An exact plane has no curvature to speak of: depths are never known better than a thousandth of
  // the extent.
  const double variance = std::max(1e-6, (zz - fit.dot(g)) / (count - 4));
  return fit(3) / std::sqrt(variance * H.inverse()(3, 3));
}

StartOutcome run_start_contest(const StartProblem& problem,
                               const StartOptions& options,
                               StartWorkspace& workspace) {
  StartOutcome out;
  if (!select_contest_set(problem, &workspace.set)) {
    return out;
  }
  out.crowded = is_crowded(problem, workspace.set);
  Contest contest{.problem = problem, .options = options, .w = workspace};
  hold_contest(&contest);
  if (workspace.refined.empty()) {
    out.decision = StartDecision::kNoHypothesis;
    return out;
  }
  StartHypothesis& winner = workspace.refined[0];
  const double noise = contest.sigma_scale * winner.fit.noise_scale;
  out.winner = winner.kind;
  out.winner_reversed = winner.reversed;
  out.hypotheses = static_cast<int>(workspace.refined.size());
  out.reduced_chi2 = noise * noise;
  out.inlier_ratio = static_cast<double>(winner.fit.inliers) / winner.fit.sightings;
  out.chi2_gap = chi2_gap(contest);
  out.convexity = convexity_of(contest, &winner);
  adjust_all_tracks(contest, &out);
  out.decision = decide(out, options, noise);
  return out;
}

}  // namespace polhode
