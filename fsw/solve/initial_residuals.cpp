#include "solve/initial_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"
#include "base/median.hpp"

namespace polhode {
namespace {

/// Bound on the cost of a track of n observations with the truncated loss. A track beyond it
/// belongs to no point of the body, so its cost is not evidence against a motion.
double track_cost_max(std::size_t observations) {
  // Standard deviations of chi-square, sqrt(2 f), above its mean f.
  constexpr double kSigmas = 3.0;
  const double free = std::max(1.0, 2.0 * static_cast<double>(observations) - 3.0);
  return free + kSigmas * std::sqrt(2.0 * free);
}

/// Poses and points of a geometry, or of a trial in its place.
struct Candidate {
  std::span<const InverseDepthPose> poses;
  std::span<const Eigen::Vector3d> points_T;
};

Candidate candidate_of(const InitialGeometryView& geometry) {
  return {.poses = geometry.poses, .points_T = geometry.points_T};
}

double scaled_error2(const Candidate& candidate,
                     const TrackObservation& observation,
                     const InitialAdjustmentOptions& options) {
  Eigen::Vector2d x;
  if (!reproject(candidate.poses[static_cast<std::size_t>(observation.frame)],
                 candidate.points_T[static_cast<std::size_t>(observation.track)],
                 &x)) {
    return behind_error2(options);
  }
  const double sigma = observation.sigma_normalised * options.sigma_scale;
  return (x - observation.normalised).squaredNorm() / (sigma * sigma);
}

double cauchy_cost(std::span<const TrackObservation> observations,
                   const Candidate& candidate,
                   const InitialGeometryView& geometry,
                   const InitialAdjustmentOptions& options) {
  CauchySum sum(options.width_sigma);
  for (const TrackObservation& s : observations) {
    if (usable(geometry, s)) {
      sum.add(scaled_error2(candidate, s, options));
    }
  }
  return sum.value();
}

TrackCost truncated_cost(std::span<const TrackObservation> run,
                         const Candidate& candidate,
                         const InitialGeometryView& geometry,
                         const InitialAdjustmentOptions& options) {
  const double lost = truncated_max(options);
  TrackCost sum;
  for (const TrackObservation& s : run) {
    sum.cost += usable(geometry, s) ? std::min(scaled_error2(candidate, s, options), lost) : lost;
  }
  const double most = track_cost_max(run.size());
  return sum.cost > most ? TrackCost{.cost = most, .wrong = true} : sum;
}

}  // namespace

std::size_t track_end(std::span<const TrackObservation> observations, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < observations.size() && observations[end].track == observations[begin].track) {
    ++end;
  }
  return end;
}

TrackCost track_cost(std::span<const TrackObservation> run,
                     const InitialGeometryView& geometry,
                     const InitialAdjustmentOptions& options) {
  const Candidate own = candidate_of(geometry);
  return options.loss == InitialLoss::kTruncated
             ? truncated_cost(run, own, geometry, options)
             : TrackCost{.cost = cauchy_cost(run, own, geometry, options)};
}

double total_cost(std::span<const TrackObservation> observations,
                  std::span<const InverseDepthPose> poses,
                  std::span<const Eigen::Vector3d> points_T,
                  const InitialGeometryView& geometry,
                  const InitialAdjustmentOptions& options) {
  const Candidate candidate{.poses = poses, .points_T = points_T};
  return with_avx2([&] {
    if (options.loss == InitialLoss::kCauchy) {
      return cauchy_cost(observations, candidate, geometry, options);
    }
    double cost = 0.0;
    for (std::size_t begin = 0; begin < observations.size();) {
      const std::size_t end = track_end(observations, begin);
      cost += truncated_cost(observations.subspan(begin, end - begin), candidate, geometry, options)
                  .cost;
      begin = end;
    }
    return cost;
  });
}

InitialFit evaluate_initial(std::span<const TrackObservation> observations,
                            const InitialGeometryView& geometry,
                            const InitialAdjustmentOptions& options,
                            InitialAdjustmentWorkspace* workspace) {
  POLHODE_ASSERT(observations.size() <= InitialAdjustmentWorkspace::kInitialObservations,
                 observations.size());
  InitialFit fit;
  const double width2 = options.width_sigma * options.width_sigma;
  workspace->errors2.clear();
  for (std::size_t begin = 0; begin < observations.size();) {
    const std::size_t end = track_end(observations, begin);
    int track_inliers = 0;
    double track_chi2 = 0.0;
    const std::span run = observations.subspan(begin, end - begin);
    const bool wrong = track_cost(run, geometry, options).wrong;
    for (std::size_t i = begin; i < end; ++i) {
      const TrackObservation& s = observations[i];
      if (!usable(geometry, s)) {
        continue;
      }
      const double e = scaled_error2(candidate_of(geometry), s, options);
      (void)workspace->errors2.push_back(e);
      if (e < width2) {
        ++track_inliers;
        track_chi2 += e;
      }
    }
    fit.inliers += wrong ? 0 : track_inliers;
    // A point fits nearly any two observations of it: only the further ones are redundant.
    fit.redundant += std::max(0, static_cast<int>(end - begin) - 2);
    fit.agreeing += std::max(0, track_inliers - 2);
    fit.chi2 += wrong ? 0.0 : track_chi2;
    fit.points += track_inliers >= 2 ? 1 : 0;
    begin = end;
  }
  fit.observations = static_cast<int>(observations.size());
  for (const std::uint8_t posed : geometry.posed) {
    fit.frames += posed != 0 ? 1 : 0;
  }
  fit.cost = total_cost(observations, geometry.poses, geometry.points_T, geometry, options);
  fit.median = median(workspace->errors2.view());
  // The fit uses 3 degrees of freedom of every point and 6 of every frame, less the gauge's 7.
  const double coordinates = 2.0 * static_cast<double>(workspace->errors2.size());
  const double free = coordinates - 3.0 * fit.points - 6.0 * fit.frames + 7.0;
  fit.noise_scale = free > 0.0 ? std::sqrt(fit.median / kChi2Median2 * coordinates / free) : 0.0;
  return fit;
}

void initial_track_costs(std::span<const TrackObservation> observations,
                         const InitialGeometryView& geometry,
                         const InitialAdjustmentOptions& options,
                         std::span<double> costs) {
  POLHODE_ASSERT(costs.size() == geometry.points_T.size(), costs.size());
  std::fill(costs.begin(), costs.end(), 0.0);
  for (std::size_t begin = 0; begin < observations.size();) {
    const std::size_t end = track_end(observations, begin);
    costs[static_cast<std::size_t>(observations[begin].track)] =
        track_cost(observations.subspan(begin, end - begin), geometry, options).cost;
    begin = end;
  }
}

}  // namespace polhode
