// Neighbours of points in space, by FLANN's single kd-tree: exact, without chance.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {

using PointIndices = FixedVector<std::uint16_t, limits::kCloudPoints>;
static_assert(limits::kCloudPoints <= 65535);

/// A tree over points. It takes heap while it lives (decision 0062).
class PointTree {
 public:
  /// @param points  finite, at most limits::kCloudPoints, or none; they must outlive the tree
  /// unchanged.
  /// @cost  O(N log N); each search O(log N) and its results.
  explicit PointTree(std::span<const Eigen::Vector3d> points);
  ~PointTree();
  PointTree(const PointTree&) = delete;
  PointTree& operator=(const PointTree&) = delete;

  /// All points within `radius` of a place, in ascending order of x (of equal x: of their index).
  void within(const Eigen::Vector3d& place, double radius, PointIndices* found) const;

  /// Is there such a point?
  [[nodiscard]] bool any_within(const Eigen::Vector3d& place, double radius) const;

  /// Squared distance from a point to its k-th nearest other one.
  /// @pre there are k others
  [[nodiscard]] double kth_distance2(std::size_t point, std::size_t k) const;

 private:
  static constexpr std::size_t kTreeBytes = 512;  ///< at least a FLANN index's own size
  std::span<const Eigen::Vector3d> points_;
  alignas(16) std::byte tree_[kTreeBytes];
};

}  // namespace polhode
