#include "initialisation/convexity.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace polhode {

namespace {

// Points farther from the origin, in RMS extents of the body, are wrong tracks. Chosen.
constexpr double kHullReachMax = 4.0;
// Twice the four coefficients of the fit.
constexpr int kHullPointsMin = 8;
// A thousandth of the extent, squared: depths are never known better. It bounds the cue on an exact
// plane, whose residuals vanish.
constexpr double kVarianceMin = 1e-6;

}  // namespace

double convexity_cue(std::span<const TrackObservation> observations,
                     int frame,
                     const InitialGeometryView& geometry) {
  if (geometry.posed[static_cast<std::size_t>(frame)] == 0) {
    return 0.0;
  }
  const InverseDepthPose& pose = geometry.poses[static_cast<std::size_t>(frame)];
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  double zz = 0.0;
  int count = 0;
  for (const TrackObservation& s : observations) {
    const auto track = static_cast<std::size_t>(s.track);
    if (s.frame != frame || geometry.known[track] == 0 ||
        geometry.points_T[track].norm() > kHullReachMax) {
      continue;
    }
    const Eigen::Vector3d q = pose.R_CT * geometry.points_T[track];
    const Eigen::Vector4d row(1.0, q.x(), q.y(), q.head<2>().squaredNorm());
    H += row * row.transpose();
    g += row * q.z();
    zz += q.z() * q.z();
    ++count;
  }
  if (count < kHullPointsMin) {
    return 0.0;
  }
  const Eigen::Vector4d fit = H.ldlt().solve(g);
  const double variance = std::max(kVarianceMin, (zz - fit.dot(g)) / (count - 4));
  return fit(3) / std::sqrt(variance * H.inverse()(3, 3));
}

}  // namespace polhode
