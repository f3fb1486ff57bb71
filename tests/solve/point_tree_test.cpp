// The tree finds what a search through all points finds.
#include "solve/point_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "base/rng.hpp"

namespace polhode::point_tree_test {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points scattered(std::size_t count, std::uint64_t seed) {
  Rng random(seed, 0);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    points.emplace_back(random.uniform(), random.uniform(), 0.1 * random.uniform());
  }
  return points;
}

std::vector<std::uint16_t> all_within(const Points& points,
                                      const Eigen::Vector3d& place,
                                      double radius) {
  std::vector<std::uint16_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - place).squaredNorm() <= radius * radius) {
      found.push_back(static_cast<std::uint16_t>(i));
    }
  }
  std::sort(found.begin(), found.end(), [&](std::uint16_t a, std::uint16_t b) {
    return points[a].x() != points[b].x() ? points[a].x() < points[b].x() : a < b;
  });
  return found;
}

class PointTrees : public ::testing::TestWithParam<std::size_t> {};

TEST_P(PointTrees, FindAllPointsWithinARadius_AndNoOthers) {
  const Points points = scattered(GetParam(), 3);
  const PointTree tree(points);
  const auto found = std::make_unique<PointIndices>();
  for (const double radius : {0.0, 0.01, 0.1, 5.0}) {
    for (std::size_t i = 0; i < points.size(); i += 7) {
      tree.within(points[i], radius, found.get());
      const std::vector<std::uint16_t> expected = all_within(points, points[i], radius);
      EXPECT_TRUE(std::equal(found->begin(), found->end(), expected.begin(), expected.end())) << i;
      const Eigen::Vector3d beside = points[i] + Eigen::Vector3d(0.05, -0.02, 0.01);
      EXPECT_EQ(tree.any_within(beside, radius), !all_within(points, beside, radius).empty());
    }
  }
}

TEST_P(PointTrees, KnowTheDistanceToTheKthNearestOtherPoint) {
  const Points points = scattered(GetParam(), 4);
  const PointTree tree(points);
  for (std::size_t i = 0; i < points.size(); i += 5) {
    std::vector<double> distances2;
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (j != i) {
        distances2.push_back((points[j] - points[i]).squaredNorm());
      }
    }
    std::sort(distances2.begin(), distances2.end());
    for (const std::size_t k : {std::size_t{1}, std::size_t{4}, std::size_t{8}}) {
      EXPECT_EQ(tree.kth_distance2(i, k), distances2[k - 1]) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, PointTrees, ::testing::Values(9, 11, 500, 3000));

TEST(PointTree, OnTheRadiusIsWithinIt) {
  const Points points{{0.0, 0.0, 0.0}, {3.0, 4.0, 0.0}, {-3.0, -4.0, 1e-6}};
  const PointTree tree(points);
  const auto found = std::make_unique<PointIndices>();
  tree.within(points[0], 5.0, found.get());
  ASSERT_EQ(found->size(), 2U);
  EXPECT_EQ((*found)[0], 0);
  EXPECT_EQ((*found)[1], 1);
}

TEST(PointTree, PointsThatCoincideAreAllFound) {
  const Points points(100, Eigen::Vector3d(1.0, 2.0, 3.0));
  const PointTree tree(points);
  const auto found = std::make_unique<PointIndices>();
  tree.within(points[0], 0.0, found.get());
  EXPECT_EQ(found->size(), 100U);
  EXPECT_EQ(tree.kth_distance2(0, 4), 0.0);
}

TEST(PointTree, OfNoPointsFindsNone) {
  const PointTree tree({});
  const auto found = std::make_unique<PointIndices>();
  tree.within(Eigen::Vector3d::Zero(), 1.0, found.get());
  EXPECT_TRUE(found->empty());
  EXPECT_FALSE(tree.any_within(Eigen::Vector3d::Zero(), 1.0));
}

}  // namespace
}  // namespace polhode::point_tree_test
