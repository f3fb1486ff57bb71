#include "shape/normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/median.hpp"

namespace polhode {
namespace {

// Least radius, in spacings. Random points on a surface have 7 others within 3 spacings (density
// 0.25 per squared spacing): four more than a plane needs. Smaller leaves too few, larger smooths
// over edges.
constexpr double kRadiusMin_spacings = 3.0;
// Largest radius, with 110 such points. Chosen; more noise than such a disc averages out hides any
// shape.
constexpr double kRadiusMax_spacings = 12.0;
// Least radius in thicknesses. A disc of this radius has a variance of radius^2 / 4 = 9 thickness^2
// in its plane. Least over middle eigenvalue is then 0.11, below kFlatnessMax.
constexpr double kRadius_thicknesses = 6.0;
// Passes at most. Chosen: a wider radius gives a larger thickness, and the loop ends once both
// agree.
constexpr int kRadiusPasses = 3;
// Least growth of the radius for another pass: a tenth.
constexpr double kRadiusGrowthMin = 1.1;
// A normal needs more points than this, itself included: six are three more than a plane needs.
constexpr int kNeighboursMin = 5;
// Largest ratio of least over middle eigenvalue: 0.15 is a thickness of 0.4 of the width. An edge
// of 90 deg through the middle gives 0.28.
constexpr double kFlatnessMax = 0.15;
// Least ratio of middle over largest eigenvalue. Below it the neighbours lie on a line, which
// determines no plane. Chosen: a strip 0.22 as wide as it is long.
constexpr double kBreadthMin = 0.05;

}  // namespace

double estimate_normals(std::span<const Eigen::Vector3d> points_T,
                        double radius,
                        CloudScratch& scratch,
                        SurfaceNormals& normals) {
  normals.clear();
  normals.resize(points_T.size());
  FixedVector<float, limits::kCloudPoints> thicknesses;
  const PointTree tree(points_T);
  for (std::size_t at = 0; at < points_T.size(); ++at) {
    tree.within(points_T[at], radius, &scratch.indices);
    const auto count = static_cast<int>(scratch.indices.size());  // itself among them
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    // Order of the neighbours: by distance in x from the point, independent of the tree.
    const auto add = [&](std::uint16_t other) {
      const Eigen::Vector3d apart = points_T[other] - points_T[at];
      sum += apart;
      square += apart * apart.transpose();
    };
    const std::span<const std::uint16_t> near = scratch.indices.view();
    const auto self = std::find(near.begin(), near.end(), at);
    std::for_each(std::reverse_iterator(self), near.rend(), add);
    std::for_each(self + 1, near.end(), add);
    if (count <= kNeighboursMin) {
      continue;
    }
    const Eigen::Matrix3d scatter = square - sum * sum.transpose() / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
    const Eigen::Vector3d& values = eigen.eigenvalues();
    normals[at] = {
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
  for (int pass = 0;
       pass < kRadiusPasses && kRadius_thicknesses * thickness > kRadiusGrowthMin * radius;
       ++pass) {
    radius = std::min(kRadius_thicknesses * thickness, kRadiusMax_spacings * spacing);
    thickness = estimate_normals(points_T, radius, scratch, normals);
  }
  return thickness;
}

}  // namespace polhode
