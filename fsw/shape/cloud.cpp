#include "shape/cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/median.hpp"

namespace polhode {
namespace {

// The fourth nearest, not the first: features come in clumps.
constexpr std::size_t kNeighbour = 4;
// For random points on a plane the mean distance to the k-th nearest goes as
// Gamma(k + 1/2) / Gamma(k). The ratio of k = 4 to k = 1 is 1.939 / 0.886.
constexpr double kFourthOverFirst = 2.19;

/// Calls visit(squared distance in x, squared distance) for the other points. Goes from place `at`
/// in both directions of x, in each until visit returns false.
template <typename Visit>
void scan_along_x(std::span<const Eigen::Vector3d> points_T,
                  const CloudIndices& by_x,
                  std::size_t at,
                  const Visit& visit) {
  const Eigen::Vector3d& centre = points_T[by_x[at]];
  for (const int direction : {-1, 1}) {
    for (auto i = static_cast<std::ptrdiff_t>(at) + direction;
         i >= 0 && i < static_cast<std::ptrdiff_t>(by_x.size());
         i += direction) {
      const std::uint16_t other = by_x[static_cast<std::size_t>(i)];
      const double dx = points_T[other].x() - centre.x();
      if (!visit(dx * dx, (points_T[other] - centre).squaredNorm())) {
        break;
      }
    }
  }
}

/// Squared distance to the k-th nearest other point.
double kth_distance2(std::span<const Eigen::Vector3d> points_T,
                     const CloudIndices& by_x,
                     std::size_t at) {
  std::array<double, kNeighbour> nearest{};
  nearest.fill(std::numeric_limits<double>::infinity());
  scan_along_x(points_T, by_x, at, [&nearest](double dx2, double distance2) {
    if (dx2 > nearest.back()) {
      return false;
    }
    for (double& kept : nearest) {
      if (distance2 < kept) {
        std::swap(distance2, kept);
      }
    }
    return true;
  });
  return nearest.back();
}

/// Number of the cube that holds a coordinate. Far points share the outermost cubes.
std::int64_t cube(double coordinate, double edge) {
  // Keeps the conversion to an integer defined. A body spans far fewer cubes.
  constexpr double kCubeMax = 1'000'000.0;
  return static_cast<std::int64_t>(std::clamp(std::floor(coordinate / edge), -kCubeMax, kCubeMax));
}

bool same_cube(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double edge) {
  return cube(a.x(), edge) == cube(b.x(), edge) && cube(a.y(), edge) == cube(b.y(), edge) &&
         cube(a.z(), edge) == cube(b.z(), edge);
}

}  // namespace

void sort_by_x(std::span<const Eigen::Vector3d> points_T, CloudScratch& scratch) {
  CloudIndices& by_x = scratch.by_x;
  by_x.clear();
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    POLHODE_ASSERT(by_x.push_back(static_cast<std::uint16_t>(i)), i);
  }
  std::sort(by_x.begin(), by_x.end(), [points_T](std::uint16_t a, std::uint16_t b) {
    return points_T[a].x() != points_T[b].x() ? points_T[a].x() < points_T[b].x() : a < b;
  });
}

Result<double> median_spacing(std::span<const Eigen::Vector3d> points_T, CloudScratch& scratch) {
  if (points_T.size() <= kNeighbour) {
    return ErrorCode::kTooFewObservations;
  }
  sort_by_x(points_T, scratch);
  FixedVector<float, limits::kCloudPoints> distances;
  for (std::size_t at = 0; at < points_T.size(); ++at) {
    POLHODE_ASSERT(distances.push_back(
                       static_cast<float>(std::sqrt(kth_distance2(points_T, scratch.by_x, at)))),
                   at);
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
  const std::span<const Eigen::Vector3d> points_T = cloud.points_T.view();
  sort_by_x(points_T, scratch);
  FixedVector<std::uint8_t, limits::kCloudPoints> keep;
  keep.resize(before);
  for (std::size_t at = 0; at < before; ++at) {
    int neighbours = 0;
    visit_neighbours(
        points_T, scratch.by_x, at, radius, [&neighbours, radius](std::uint16_t, double distance2) {
          neighbours += distance2 <= radius * radius ? 1 : 0;
        });
    keep[scratch.by_x[at]] = neighbours >= neighbours_min ? 1 : 0;
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
  sort_by_x(points_T, scratch);
  std::sort(
      scratch.by_x.begin(), scratch.by_x.end(), [points_T, edge](std::uint16_t a, std::uint16_t b) {
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
           same_cube(points_T[scratch.by_x[first]], points_T[scratch.by_x[next]], edge)) {
      sum += points_T[scratch.by_x[next++]];
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
  const Result<double> spacing = median_spacing(cloud.points_T.view(), scratch);
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
