#include "shape/normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/median.hpp"

namespace polhode {
namespace {

constexpr double kRadiusMin_spacings = 3.0;
constexpr double kRadiusMax_spacings =
    12.0;  // some 450 points on a surface: more noise than that leaves no shape
// Across six thicknesses (12 of them wide) a surface is seen as flat: least over middle eigenvalue
// 0.11.
constexpr double kRadius_thicknesses = 6.0;
constexpr int kRadiusPasses = 3;
constexpr int kNeighboursMin = 5;
// Least over middle eigenvalue: 0.15 is a thickness of 0.4 of the width, the most that an edge of
// 90 deg leaves untouched.
constexpr double kFlatnessMax = 0.15;
// Middle over largest: below, the neighbours lie on a line and any plane through it fits.
constexpr double kBreadthMin = 0.05;

}  // namespace

double estimate_normals(std::span<const Eigen::Vector3d> points_T,
                        double radius,
                        CloudScratch& scratch,
                        SurfaceNormals& normals) {
  sort_by_x(points_T, scratch);
  normals.clear();
  normals.resize(points_T.size());
  FixedVector<float, limits::kCloudPoints> thicknesses;
  for (std::size_t at = 0; at < points_T.size(); ++at) {
    const Eigen::Vector3d& centre_T = points_T[scratch.by_x[at]];
    int count = 1;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    visit_neighbours(
        points_T, scratch.by_x, at, radius, [&](std::uint16_t other, double distance2) {
          if (distance2 <= radius * radius) {
            const Eigen::Vector3d apart = points_T[other] - centre_T;
            sum += apart;
            square += apart * apart.transpose();
            ++count;
          }
        });
    if (count <= kNeighboursMin) {
      continue;
    }
    const Eigen::Matrix3d scatter = square - sum * sum.transpose() / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
    const Eigen::Vector3d& values = eigen.eigenvalues();
    normals[scratch.by_x[at]] = {
        .normal_T = eigen.eigenvectors().col(0),
        .reliable = values(0) <= kFlatnessMax * values(1) && values(1) >= kBreadthMin * values(2)};
    const double variance =
        std::max(0.0, values(0)) / (count - 3);  // a plane takes three of the degrees of freedom
    POLHODE_ASSERT(thicknesses.push_back(static_cast<float>(std::sqrt(variance))), at);
  }
  return static_cast<double>(median(thicknesses.view()));
}

double estimate_normals_by_spacing(std::span<const Eigen::Vector3d> points_T,
                                   double spacing,
                                   CloudScratch& scratch,
                                   SurfaceNormals& normals) {
  double radius = kRadiusMin_spacings * spacing;
  double thickness = estimate_normals(points_T, radius, scratch, normals);
  for (int pass = 0; pass < kRadiusPasses && kRadius_thicknesses * thickness > 1.1 * radius;
       ++pass) {
    radius = std::min(kRadius_thicknesses * thickness, kRadiusMax_spacings * spacing);
    thickness = estimate_normals(points_T, radius, scratch, normals);
  }
  return thickness;
}

}  // namespace polhode
