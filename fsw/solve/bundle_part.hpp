// Selects a part of a bundle that fits an adjustment's memory and time.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Selects points with at most `observations_max` observations in all, and at most a third of that
/// number of points. Every pose keeps its share; among the candidates those with most observations
/// come first. All points where they fit.
/// @return 1 for each selected point.
std::vector<std::uint8_t> choose_points(const BundleProblem& problem, std::size_t observations_max);

/// The selected points with their observations, as a problem of its own on the same poses.
class BundlePart {
 public:
  BundlePart(const BundleProblem& whole, std::size_t observations_max);
  BundlePart(const BundlePart&) = delete;
  BundlePart& operator=(const BundlePart&) = delete;

  [[nodiscard]] const BundleProblem& problem() const { return part_; }

  /// Writes the points back, and re-solves the omitted ones for the present poses.
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
