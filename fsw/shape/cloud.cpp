#include "shape/cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/median.hpp"

namespace polhode {
namespace {

// Neighbour whose distance gives the spacing: not the nearest, as features come in clumps.
constexpr std::size_t kNeighbour = 4;
// For random points on a plane the mean distance to the k-th nearest goes as
// Gamma(k + 1/2) / Gamma(k). The ratio of k = 4 to k = 1 is 1.939 / 0.886.
constexpr double kFourthOverFirst = 2.19;

/// Number of the cube that contains a coordinate. Far points share the outermost cubes.
std::int64_t cube(double coordinate, double edge) {
  // Keeps the conversion to an integer defined. A body spans far fewer cubes.
  constexpr double kCubeMax = 1'000'000.0;
  return static_cast<std::int64_t>(std::clamp(std::floor(coordinate / edge), -kCubeMax, kCubeMax));
}

}  // namespace

std::array<std::int64_t, 3> cube_of(const Eigen::Vector3d& point_T, double edge) {
  return {cube(point_T.x(), edge), cube(point_T.y(), edge), cube(point_T.z(), edge)};
}

Result<double> median_spacing(std::span<const Eigen::Vector3d> points_T) {
  if (points_T.size() <= kNeighbour) {
    return ErrorCode::kTooFewObservations;
  }
  const PointTree tree(points_T);
  FixedVector<float, limits::kCloudPoints> distances;
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    POLHODE_ASSERT(
        distances.push_back(static_cast<float>(std::sqrt(tree.kth_distance2(i, kNeighbour)))), i);
  }
  const double spacing = static_cast<double>(median(distances.view())) / kFourthOverFirst;
  if (!(spacing > 0.0) || !std::isfinite(spacing)) {
    return ErrorCode::kDegenerate;
  }
  return spacing;
}

std::size_t remove_outliers(double radius,
                            int neighbours_min,
                            CloudScratch& scratch,
                            Cloud& cloud) {
  const std::size_t before = cloud.points_T.size();
  const PointTree tree(cloud.points_T.view());
  FixedVector<std::uint8_t, limits::kCloudPoints> keep;
  keep.resize(before);
  for (std::size_t i = 0; i < before; ++i) {
    tree.within(cloud.points_T[i], radius, &scratch.indices);
    const auto others = static_cast<int>(scratch.indices.size()) - 1;  // not itself
    keep[i] = others >= neighbours_min ? 1 : 0;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < before; ++i) {
    if (keep[i] != 0) {
      cloud.points_T[kept++] = cloud.points_T[i];
    }
  }
  while (cloud.points_T.size() > kept) {
    cloud.points_T.pop_back();
  }
  cloud.measured = kept;
  return before - kept;
}

std::size_t homogenise(double edge, CloudScratch& scratch, Cloud& cloud) {
  POLHODE_ASSERT(edge > 0.0, edge);
  const std::size_t before = cloud.points_T.size();
  const std::span<const Eigen::Vector3d> points_T = cloud.points_T.view();
  CloudIndices& by_cube = scratch.indices;
  by_cube.resize(before);
  std::iota(by_cube.begin(), by_cube.end(), std::uint16_t{0});
  std::sort(by_cube.begin(), by_cube.end(), [points_T, edge](std::uint16_t a, std::uint16_t b) {
    for (const Eigen::Index k : {0, 1, 2}) {
      const std::int64_t cube_a = cube(points_T[a](k), edge);
      const std::int64_t cube_b = cube(points_T[b](k), edge);
      if (cube_a != cube_b) {
        return cube_a < cube_b;
      }
    }
    return a < b;
  });
  auto& means_T = scratch.points_T;
  means_T.clear();
  for (std::size_t first = 0; first < before;) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t next = first;
    while (next < before &&
           cube_of(points_T[by_cube[first]], edge) == cube_of(points_T[by_cube[next]], edge)) {
      sum += points_T[by_cube[next++]];
    }
    POLHODE_ASSERT(means_T.push_back(sum / static_cast<double>(next - first)), first);
    first = next;
  }
  cloud.points_T = means_T;
  cloud.measured = means_T.size();
  return before - means_T.size();
}

Eigen::Vector3d centroid_T(std::span<const Eigen::Vector3d> points_T) {
  POLHODE_ASSERT(!points_T.empty(), points_T.size());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point_T : points_T) {
    sum += point_T;
  }
  return sum / static_cast<double>(points_T.size());
}

Result<double> denoise(std::span<const Eigen::Vector3d> landmarks_T,
                       const ShapeOptions& options,
                       CloudScratch& scratch,
                       Cloud& cloud) {
  cloud.points_T.clear();
  for (const Eigen::Vector3d& landmark_T : landmarks_T) {
    if (landmark_T.allFinite() && !cloud.points_T.push_back(landmark_T)) {
      break;
    }
  }
  cloud.measured = cloud.points_T.size();
  const Result<double> spacing = median_spacing(cloud.points_T.view());
  if (!spacing) {
    return spacing.error();
  }
  remove_outliers(options.outlier_radius_spacings * spacing.value(),
                  options.outlier_neighbours_min,
                  scratch,
                  cloud);
  if (cloud.points_T.empty()) {
    return ErrorCode::kTooFewObservations;
  }
  homogenise(options.voxel_spacings * spacing.value(), scratch, cloud);
  return spacing.value();
}

}  // namespace polhode
