#include "solve/start_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/median.hpp"

namespace polhode {
namespace {

// Half of a chi-square with two degrees of freedom lies under this.
constexpr double kChi2Median2 = 1.3863;
// The squared residual, in units of width^2, that stands for a point behind the camera.
constexpr double kBehindError = 1e4;

double scaled_error2(const InverseDepthPose& pose,
                     const Eigen::Vector3d& p_T,
                     const StartSighting& sighting,
                     const StartAdjustmentOptions& options) {
  Eigen::Vector2d x;
  if (!reproject(pose, p_T, &x)) {
    return behind_error2(options);
  }
  const double sigma = sighting.sigma_normalised * options.sigma_scale;
  return (x - sighting.normalised).squaredNorm() / (sigma * sigma);
}

/// What a track of n sightings may cost with the truncated loss: 3 sigma above the mean of its
/// chi-square. One that costs more belongs to no point of the body, and how badly it fits says
/// nothing about the motion.
double track_cost_max(std::size_t sightings) {
  const double free = std::max(1.0, 2.0 * static_cast<double>(sightings) - 3.0);
  return free + 3.0 * std::sqrt(2.0 * free);
}

}  // namespace

LossValue start_loss(double error2, const StartAdjustmentOptions& options) {
  const double width2 = options.width_sigma * options.width_sigma;
  if (options.loss == StartLoss::kTruncated) {
    return error2 < width2 ? LossValue{error2, 1.0} : LossValue{width2, 0.0};
  }
  return {width2 * std::log1p(error2 / width2), 1.0 / (1.0 + error2 / width2)};
}

double behind_error2(const StartAdjustmentOptions& options) {
  return kBehindError * options.width_sigma * options.width_sigma;
}

bool usable(const StartGeometryView& geometry, const StartSighting& sighting) {
  return geometry.posed[static_cast<std::size_t>(sighting.frame)] != 0 &&
         geometry.known[static_cast<std::size_t>(sighting.track)] != 0;
}

std::size_t track_end(std::span<const StartSighting> sightings, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < sightings.size() && sightings[end].track == sightings[begin].track) {
    ++end;
  }
  return end;
}

TrackCost track_cost(std::span<const StartSighting> run,
                     std::span<const InverseDepthPose> poses,
                     std::span<const Eigen::Vector3d> points,
                     const StartGeometryView& geometry,
                     const StartAdjustmentOptions& options) {
  TrackCost sum;
  const bool limited = options.loss == StartLoss::kTruncated;
  for (const StartSighting& s : run) {
    if (usable(geometry, s)) {
      const double e = scaled_error2(poses[static_cast<std::size_t>(s.frame)],
                                     points[static_cast<std::size_t>(s.track)],
                                     s,
                                     options);
      sum.cost += start_loss(e, options).cost;
    } else if (limited) {
      sum.cost += options.width_sigma * options.width_sigma;
    }
  }
  sum.wrong = limited && sum.cost > track_cost_max(run.size());
  if (sum.wrong) {
    sum.cost = track_cost_max(run.size());
  }
  return sum;
}

double total_cost(std::span<const StartSighting> sightings,
                  std::span<const InverseDepthPose> poses,
                  std::span<const Eigen::Vector3d> points,
                  const StartGeometryView& geometry,
                  const StartAdjustmentOptions& options) {
  double cost = 0.0;
  for (std::size_t begin = 0; begin < sightings.size();) {
    const std::size_t end = track_end(sightings, begin);
    cost +=
        track_cost(sightings.subspan(begin, end - begin), poses, points, geometry, options).cost;
    begin = end;
  }
  return cost;
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
    const bool wrong = track_cost(run, geometry.poses, geometry.points_T, geometry, options).wrong;
    for (std::size_t i = begin; i < end; ++i) {
      const StartSighting& s = sightings[i];
      if (!usable(geometry, s)) {
        continue;
      }
      const double e = scaled_error2(geometry.poses[static_cast<std::size_t>(s.frame)],
                                     geometry.points_T[static_cast<std::size_t>(s.track)],
                                     s,
                                     options);
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
        track_cost(sightings.subspan(begin, end - begin),
                   geometry.poses,
                   geometry.points_T,
                   geometry,
                   options)
            .cost;
    begin = end;
  }
}

}  // namespace polhode
