#include "geometry/alignment.hpp"

namespace polhode {

Pose transformed(const Pose& pose_a, const Similarity& b_of_a) {
  // p_C = R a + t with b = c Q a + q: c p_C = (R Q^T)(b - q) + c t.
  const Eigen::Matrix3d R_Cb = pose_a.R_CT * b_of_a.R_ba.transpose();
  return {.R_CT = R_Cb, .p_CT = b_of_a.scale * pose_a.p_CT - R_Cb * b_of_a.t_ba};
}

Result<Similarity> align_rotated(std::span<const Eigen::Vector3d> points_a,
                                 std::span<const Eigen::Vector3d> points_b,
                                 std::span<const double> weights,
                                 const Eigen::Matrix3d& R_ba) {
  POLHODE_ASSERT(points_a.size() == points_b.size() && points_a.size() == weights.size(),
                 points_a.size());
  double total = 0.0;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    total += weights[i];
    mean_a += weights[i] * points_a[i];
    mean_b += weights[i] * points_b[i];
  }
  if (!(total > 0.0)) {
    return ErrorCode::kTooFewObservations;
  }
  mean_a /= total;
  mean_b /= total;
  double together = 0.0;
  double spread_a = 0.0;
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    together += weights[i] * (points_b[i] - mean_b).dot(R_ba * (points_a[i] - mean_a));
    spread_a += weights[i] * (points_a[i] - mean_a).squaredNorm();
  }
  if (!(spread_a > 0.0) || !(together > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  Similarity s;
  s.R_ba = R_ba;
  s.scale = together / spread_a;
  s.t_ba = mean_b - s.scale * R_ba * mean_a;
  return s;
}

}  // namespace polhode
