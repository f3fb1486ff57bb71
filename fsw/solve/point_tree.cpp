#include "solve/point_tree.hpp"

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <new>

#include "base/assert.hpp"

namespace polhode {
namespace {

using Tree = flann::KDTreeSingleIndex<flann::L2_Simple<double>>;
// FLANN sums squares in another order than Eigen, and compares by "less than": its bound is widened
// by many roundings, and its results are measured again.
constexpr double kWider = 1.0 + 1e-12;
constexpr int kLeafPoints = 10;         // FLANN's default
constexpr std::size_t kNearestMax = 8;  // most that one query returns

/// Receives FLANN's results.
class Finds : public flann::ResultSet<double> {
 public:
  Finds(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& place)
      : points_(points), place_(place) {}

 protected:
  [[nodiscard]] double distance2(std::size_t index) const {
    return (points_[index] - place_).squaredNorm();
  }

 private:
  std::span<const Eigen::Vector3d> points_;
  Eigen::Vector3d place_;
};

class Within : public Finds {
 public:
  Within(std::span<const Eigen::Vector3d> points,
         const Eigen::Vector3d& place,
         double radius,
         PointIndices* found)
      : Finds(points, place), radius2_(radius * radius), found_(found) {}

  [[nodiscard]] bool full() const override { return true; }
  void addPoint(double /*distance2*/, std::size_t index) override {
    if (distance2(index) <= radius2_) {
      any_ = true;
      if (found_ != nullptr) {
        POLHODE_ASSERT(found_->push_back(static_cast<std::uint16_t>(index)), index);
      }
    }
  }
  [[nodiscard]] double worstDist() const override {
    return std::nextafter(radius2_ * kWider, std::numeric_limits<double>::infinity());  // also of 0
  }
  [[nodiscard]] bool any() const { return any_; }

 private:
  double radius2_;
  PointIndices* found_;
  bool any_ = false;
};

class Nearest : public Finds {
 public:
  Nearest(std::span<const Eigen::Vector3d> points, std::size_t self, std::size_t k)
      : Finds(points, points[self]), self_(self), k_(k) {
    nearest_.fill(std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] bool full() const override { return kth() < nearest_.back(); }
  void addPoint(double /*distance2*/, std::size_t index) override {
    double distance = distance2(index);
    for (std::size_t i = 0; i < k_ && index != self_; ++i) {
      if (distance < nearest_[i]) {
        std::swap(distance, nearest_[i]);
      }
    }
  }
  [[nodiscard]] double worstDist() const override { return kth() * kWider; }
  [[nodiscard]] double kth() const { return nearest_[k_ - 1]; }

 private:
  std::size_t self_;
  std::size_t k_;
  std::array<double, kNearestMax + 1> nearest_{};
};

/// @param tree  of these points; none where there are no points.
void search(std::span<const Eigen::Vector3d> points,
            const std::byte* tree,
            const Eigen::Vector3d& place,
            flann::ResultSet<double>* finds) {
  if (points.empty()) {
    return;
  }
  flann::SearchParams exact;
  exact.checks = flann::FLANN_CHECKS_UNLIMITED;
  exact.eps = 0.0F;
  exact.sorted = false;
  std::launder(reinterpret_cast<const Tree*>(tree))->findNeighbors(*finds, place.data(), exact);
}

}  // namespace

PointTree::PointTree(std::span<const Eigen::Vector3d> points) : points_(points) {
  static_assert(sizeof(Tree) <= kTreeBytes && alignof(Tree) <= 16);
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  POLHODE_ASSERT(points.size() <= limits::kCloudPoints, points.size());
  if (points.empty()) {
    return;
  }
  // FLANN reads only: reordering is switched off.
  auto* first = const_cast<double*>(points.front().data());
  const flann::Matrix<double> rows(first, points.size(), 3);
  auto* tree = ::new (static_cast<void*>(tree_))
      Tree(rows, flann::KDTreeSingleIndexParams(kLeafPoints, false));
  tree->buildIndex();
}

PointTree::~PointTree() {
  if (!points_.empty()) {
    std::destroy_at(std::launder(reinterpret_cast<Tree*>(tree_)));
  }
}

void PointTree::within(const Eigen::Vector3d& place, double radius, PointIndices* found) const {
  found->clear();
  Within finds(points_, place, radius, found);
  search(points_, tree_, place, &finds);
  std::sort(found->begin(), found->end(), [this](std::uint16_t a, std::uint16_t b) {
    return points_[a].x() != points_[b].x() ? points_[a].x() < points_[b].x() : a < b;
  });
}

bool PointTree::any_within(const Eigen::Vector3d& place, double radius) const {
  Within finds(points_, place, radius, nullptr);
  search(points_, tree_, place, &finds);
  return finds.any();
}

double PointTree::kth_distance2(std::size_t point, std::size_t k) const {
  POLHODE_ASSERT(k >= 1 && k <= kNearestMax && k < points_.size(), k);
  Nearest finds(points_, point, k);
  search(points_, tree_, points_[point], &finds);
  return finds.kth();
}

}  // namespace polhode
