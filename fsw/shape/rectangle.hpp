// Rectangle around points in a plane, robust against outliers.
#pragma once

#include <Eigen/Core>
#include <span>

namespace polhode {

struct Rectangle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d u = Eigen::Vector2d::UnitX();       ///< unit, along the longer edge
  Eigen::Vector2d extents = Eigen::Vector2d::Zero();  ///< full lengths along u and across it
};

struct Extent {
  double least = 0.0;
  double most = 0.0;
};

/// Both ends of values spread evenly over an interval: the 2 % quantiles, extrapolated to the ends.
/// Reorders `values`; zeros when empty.
Extent robust_extent(std::span<double> values);

/// The rectangle with the least area, by directions in steps of half a degree. At most
/// limits::kCloudPoints points.
Rectangle smallest_rectangle(std::span<const Eigen::Vector2d> points);

}  // namespace polhode
