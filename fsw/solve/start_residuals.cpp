#include "solve/start_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/median.hpp"
#include "base/wide.hpp"

namespace polhode {
namespace {

// Half of a chi-square with two degrees of freedom lies under this.
constexpr double kChi2Median2 = 1.3863;

/// What a track of n sightings may cost with the truncated loss: 3 sigma above the mean of its
/// chi-square. One that costs more belongs to no point of the body, and how badly it fits says
/// nothing about the motion.
double track_cost_max(std::size_t sightings) {
  const double free = std::max(1.0, 2.0 * static_cast<double>(sightings) - 3.0);
  return free + 3.0 * std::sqrt(2.0 * free);
}

/// Poses and points that may stand in for those of a geometry.
struct Candidate {
  std::span<const InverseDepthPose> poses;
  std::span<const Eigen::Vector3d> points_T;
};

Candidate candidate_of(const StartGeometryView& geometry) {
  return {.poses = geometry.poses, .points_T = geometry.points_T};
}

double scaled_error2(const Candidate& candidate,
                     const StartSighting& sighting,
                     const StartAdjustmentOptions& options) {
  Eigen::Vector2d x;
  if (!reproject(candidate.poses[static_cast<std::size_t>(sighting.frame)],
                 candidate.points_T[static_cast<std::size_t>(sighting.track)],
                 &x)) {
    return behind_error2(options);
  }
  const double sigma = sighting.sigma_normalised * options.sigma_scale;
  return (x - sighting.normalised).squaredNorm() / (sigma * sigma);
}

double cauchy_cost(std::span<const StartSighting> sightings,
                   const Candidate& candidate,
                   const StartGeometryView& geometry,
                   const StartAdjustmentOptions& options) {
  CauchySum sum(options.width_sigma);
  for (const StartSighting& s : sightings) {
    if (usable(geometry, s)) {
      sum.add(scaled_error2(candidate, s, options));
    }
  }
  return sum.value();
}

TrackCost truncated_cost(std::span<const StartSighting> run,
                         const Candidate& candidate,
                         const StartGeometryView& geometry,
                         const StartAdjustmentOptions& options) {
  const double lost = truncated_max(options);
  TrackCost sum;
  for (const StartSighting& s : run) {
    sum.cost += usable(geometry, s) ? std::min(scaled_error2(candidate, s, options), lost) : lost;
  }
  const double most = track_cost_max(run.size());
  return sum.cost > most ? TrackCost{.cost = most, .wrong = true} : sum;
}

}  // namespace

std::size_t track_end(std::span<const StartSighting> sightings, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < sightings.size() && sightings[end].track == sightings[begin].track) {
    ++end;
  }
  return end;
}

TrackCost track_cost(std::span<const StartSighting> run,
                     const StartGeometryView& geometry,
                     const StartAdjustmentOptions& options) {
  const Candidate own = candidate_of(geometry);
  return options.loss == StartLoss::kTruncated
             ? truncated_cost(run, own, geometry, options)
             : TrackCost{.cost = cauchy_cost(run, own, geometry, options)};
}

double total_cost(std::span<const StartSighting> sightings,
                  std::span<const InverseDepthPose> poses,
                  std::span<const Eigen::Vector3d> points_T,
                  const StartGeometryView& geometry,
                  const StartAdjustmentOptions& options) {
  const Candidate candidate{.poses = poses, .points_T = points_T};
  return widely([&] {
    if (options.loss == StartLoss::kCauchy) {
      return cauchy_cost(sightings, candidate, geometry, options);
    }
    double cost = 0.0;
    for (std::size_t begin = 0; begin < sightings.size();) {
      const std::size_t end = track_end(sightings, begin);
      cost +=
          truncated_cost(sightings.subspan(begin, end - begin), candidate, geometry, options).cost;
      begin = end;
    }
    return cost;
  });
}

StartFit evaluate_start(std::span<const StartSighting> sightings,
                        const StartGeometryView& geometry,
                        const StartAdjustmentOptions& options,
                        StartAdjustmentWorkspace* workspace) {
  POLHODE_ASSERT(sightings.size() <= StartAdjustmentWorkspace::kSightings, sightings.size());
  StartFit fit;
  const double width2 = options.width_sigma * options.width_sigma;
  workspace->errors2.clear();
  for (std::size_t begin = 0; begin < sightings.size();) {
    const std::size_t end = track_end(sightings, begin);
    int track_inliers = 0;
    double track_chi2 = 0.0;
    const std::span run = sightings.subspan(begin, end - begin);
    const bool wrong = track_cost(run, geometry, options).wrong;
    for (std::size_t i = begin; i < end; ++i) {
      const StartSighting& s = sightings[i];
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
    fit.chi2 += wrong ? 0.0 : track_chi2;
    fit.points += track_inliers >= 2 ? 1 : 0;
    begin = end;
  }
  fit.sightings = static_cast<int>(sightings.size());
  for (const std::uint8_t posed : geometry.posed) {
    fit.frames += posed != 0 ? 1 : 0;
  }
  fit.cost = total_cost(sightings, geometry.poses, geometry.points_T, geometry, options);
  fit.median = median(workspace->errors2.view());
  // The fit takes up 3 of every point's residuals and 6 of every frame's, less the gauge.
  const double coordinates = 2.0 * static_cast<double>(workspace->errors2.size());
  const double free = coordinates - 3.0 * fit.points - 6.0 * fit.frames + 7.0;
  fit.noise_scale = free > 0.0 ? std::sqrt(fit.median / kChi2Median2 * coordinates / free) : 0.0;
  return fit;
}

void start_track_costs(std::span<const StartSighting> sightings,
                       const StartGeometryView& geometry,
                       const StartAdjustmentOptions& options,
                       std::span<double> costs) {
  POLHODE_ASSERT(costs.size() == geometry.points_T.size(), costs.size());
  std::fill(costs.begin(), costs.end(), 0.0);
  for (std::size_t begin = 0; begin < sightings.size();) {
    const std::size_t end = track_end(sightings, begin);
    costs[static_cast<std::size_t>(sightings[begin].track)] =
        track_cost(sightings.subspan(begin, end - begin), geometry, options).cost;
    begin = end;
  }
}

}  // namespace polhode
