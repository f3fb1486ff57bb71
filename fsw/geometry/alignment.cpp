#include "geometry/alignment.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace polhode {

Pose transformed(const Pose& pose_a, const Similarity& b_of_a) {
  // p_C = R a + t with b = c Q a + q: c p_C = (R Q^T)(b - q) + c t.
  const Eigen::Matrix3d R_Cb = pose_a.R_CT * b_of_a.R_ba.transpose();
  return {.R_CT = R_Cb, .p_CT = b_of_a.scale * pose_a.p_CT - R_Cb * b_of_a.t_ba};
}

Result<Similarity> align_similarity(std::span<const Eigen::Vector3d> points_a,
                                    std::span<const Eigen::Vector3d> points_b,
                                    std::span<const double> weights) {
  POLHODE_ASSERT(points_a.size() == points_b.size() && points_a.size() == weights.size(),
                 points_a.size());
  if (points_a.size() < 3) {
    return ErrorCode::kTooFewObservations;
  }
  double total = 0.0;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    total += weights[i];
    mean_a += weights[i] * points_a[i];
    mean_b += weights[i] * points_b[i];
  }
  if (!(total > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  mean_a /= total;
  mean_b /= total;
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  double spread_a = 0.0;
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    cross += weights[i] * (points_b[i] - mean_b) * (points_a[i] - mean_a).transpose();
    spread_a += weights[i] * (points_a[i] - mean_a).squaredNorm();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& singular = svd.singularValues();
  if (!(spread_a > 0.0) || singular(1) < 1e-9 * singular(0) || !(singular(0) > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d signs(1.0, 1.0, sign);
  Similarity s;
  s.R_ba = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  s.scale = singular.dot(signs) / spread_a;
  s.t_ba = mean_b - s.scale * s.R_ba * mean_a;
  return s;
}

}  // namespace polhode
