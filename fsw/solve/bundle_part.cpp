#include "solve/bundle_part.hpp"

#include <algorithm>
#include <numeric>

#include "base/index.hpp"
#include "solve/settle_points.hpp"

namespace polhode {
namespace {

// Least mean number of observations of a point: it bounds the memory of points. Two observations
// determine a point, and leave nothing for the poses.
constexpr std::size_t kViewsMean = 3;
// Steps of a point that was left out. Chosen: it follows poses that have moved a little.
constexpr int kFollowingSteps = 5;

bool fits(const BundleProblem& problem, std::size_t observations_max) {
  return problem.observations.size() <= observations_max &&
         problem.points_T.size() <= observations_max / kViewsMean;
}

/// Points by their number of observations, most first; equal ones in their own order.
std::vector<std::size_t> by_observations(const PointObservations& by_point, std::size_t points) {
  std::vector<std::size_t> order(points);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return by_point.of(a).size() > by_point.of(b).size();
  });
  return order;
}

}  // namespace

std::vector<std::uint8_t> choose_points(const BundleProblem& problem,
                                        std::size_t observations_max) {
  if (fits(problem, observations_max)) {
    return std::vector<std::uint8_t>(problem.points_T.size(), 1);
  }
  std::vector<std::uint8_t> chosen(problem.points_T.size(), 0);
  const PointObservations by_point(problem.observations, problem.points_T.size());
  const std::vector<std::size_t> order = by_observations(by_point, problem.points_T.size());
  std::vector<std::size_t> of_pose(problem.poses.size(), 0);
  std::size_t observations_left = observations_max;
  std::size_t points_left = observations_max / kViewsMean;
  // Half of the room goes to poses with less than an equal share of that half, the rest to the
  // points with most observations.
  const std::size_t share = observations_max / (2 * problem.poses.size());
  for (const std::size_t of_each : {share, problem.observations.size()}) {
    for (const std::size_t i : order) {
      const auto views = by_point.of(i);
      const bool wanted = std::any_of(views.begin(), views.end(), [&](const BundleObservation& o) {
        return of_pose[index(o.pose)] < of_each;
      });
      if (chosen[i] == 0 && wanted && points_left > 0 && views.size() <= observations_left) {
        chosen[i] = 1;
        --points_left;
        observations_left -= views.size();
        for (const BundleObservation& o : views) {
          ++of_pose[index(o.pose)];
        }
      }
    }
  }
  return chosen;
}

BundlePart::BundlePart(const BundleProblem& whole, std::size_t observations_max)
    : whole_(whole), part_(whole) {
  if (fits(whole, observations_max)) {
    return;
  }
  const std::vector<std::uint8_t> chosen = choose_points(whole, observations_max);
  place_.assign(chosen.size(), -1);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] != 0) {
      place_[i] = static_cast<std::int32_t>(points_T_.size());
      points_T_.push_back(whole.points_T[i]);
      point_fixed_.push_back(whole.point_fixed[i]);
    }
  }
  for (BundleObservation o : whole.observations) {
    o.point = place_[index(o.point)];
    if (o.point >= 0) {
      observations_.push_back(o);
    }
  }
  part_.points_T = points_T_;
  part_.point_fixed = point_fixed_;
  part_.observations = observations_;
}

void BundlePart::put_back(double cauchy_sigma) const {
  if (place_.empty()) {
    return;
  }
  std::vector<std::uint8_t> stays(whole_.point_fixed.begin(), whole_.point_fixed.end());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    if (place_[i] >= 0) {
      whole_.points_T[i] = points_T_[index(place_[i])];
      stays[i] = 1;
    }
  }
  BundleProblem left_out = whole_;
  left_out.point_fixed = stays;
  (void)settle_points(left_out, {.iterations_max = kFollowingSteps, .cauchy_sigma = cauchy_sigma});
}

}  // namespace polhode
