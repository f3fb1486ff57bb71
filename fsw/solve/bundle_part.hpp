// As much of a bundle as an adjustment has memory and time for.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Points of a bundle whose observations are at most so many, and which are at most a third as many
/// themselves. They are chosen so that every pose keeps its share; among those the points with most
/// observations. All of them where they fit.
/// @return 1 for each point that is in.
std::vector<std::uint8_t> choose_points(const BundleProblem& problem, std::size_t observations_max);

/// The chosen points with their observations, as a problem of its own on the same poses.
class BundlePart {
 public:
  BundlePart(const BundleProblem& whole, std::size_t observations_max);
  BundlePart(const BundlePart&) = delete;
  BundlePart& operator=(const BundlePart&) = delete;

  [[nodiscard]] const BundleProblem& problem() const { return part_; }

  /// Writes the points back, and settles those that were left out at the poses as they are now.
  void put_back(double cauchy_sigma) const;

 private:
  const BundleProblem& whole_;
  std::vector<std::int32_t> place_;  ///< of a point in the part; -1: left out. Empty: all are in
  std::vector<Eigen::Vector3d> points_T_;
  std::vector<std::uint8_t> point_fixed_;
  std::vector<BundleObservation> observations_;
  BundleProblem part_;
};

}  // namespace polhode
