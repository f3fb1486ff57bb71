#include "map/reanchor.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

double weight_of(const ReanchorFrame& frame) {
  return 1.0 / (frame.predicted_sigma_rad * frame.predicted_sigma_rad);
}

/// Mean rotation from T' to T.
Eigen::Matrix3d mean_rotation(std::span<const ReanchorFrame> frames) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const ReanchorFrame& frame : frames) {
    sum += weight_of(frame) * frame.predicted.R_CT.transpose() * frame.start.R_CT;
  }
  return nearest_rotation(sum);
}

/// Bound on the change of the prediction's error over the new map's frames, which one rotation from
/// T' to T cannot absorb: the error grows, and it rotates with the body.
double changes_rad(std::span<const ReanchorFrame> frames, double turn_rad) {
  const auto [least, most] = std::minmax_element(
      frames.begin(), frames.end(), [](const ReanchorFrame& l, const ReanchorFrame& r) {
        return l.predicted_sigma_rad < r.predicted_sigma_rad;
      });
  return std::hypot(most->predicted_sigma_rad - least->predicted_sigma_rad,
                    2.0 * std::sin(0.5 * turn_rad) * most->predicted_sigma_rad);
}

void check_attitudes(std::span<const ReanchorFrame> frames, Reanchoring* reanchoring) {
  double squares = 0.0;
  for (const ReanchorFrame& frame : frames) {
    const Eigen::Matrix3d R_CT = frame.start.R_CT * reanchoring->to_T.R_ba.transpose();
    const double difference_rad = rotation_angle_rad(R_CT, frame.predicted.R_CT);
    squares += difference_rad * difference_rad;
    reanchoring->turn_rad = std::max(
        reanchoring->turn_rad, rotation_angle_rad(frame.start.R_CT, frames.front().start.R_CT));
  }
  reanchoring->misfit_rad = std::sqrt(squares / static_cast<double>(frames.size()));
  // Of the new map's rotation, 1-sigma: an initialisation is committed to when its depths, and with
  // them its rotation, have this relative error (decision 0067).
  constexpr double kTurnPart = 0.06;
  // With this phase error three sigma are within a half turn. A larger one does not constrain T,
  // however accurate the rate is.
  constexpr double kPhaseKnown_rad = 1.0;
  // A linear change has an RMS of 1 / sqrt(12) of it about its mean; 99.7 % of three numbers lie
  // within 3.8 sigma.
  constexpr double kChangePart = 1.1;
  const bool known = std::all_of(frames.begin(), frames.end(), [](const ReanchorFrame& frame) {
    return frame.predicted_sigma_rad < kPhaseKnown_rad;
  });
  reanchoring->agrees =
      known && reanchoring->misfit_rad <
                   kChangePart * std::hypot(kTurnPart * reanchoring->turn_rad,
                                            changes_rad(frames, reanchoring->turn_rad));
}

/// Scale k, origin q and the prediction's common offset d with k p' - R' Q^T q + d = p over all
/// frames. The body constrains what the translations leave undetermined: its aspects have like
/// extents, so the units of T and T', each the extent of an initialisation's landmarks, differ
/// little; and q lies on the visible face.
Eigen::Vector4d scale_and_origin(std::span<const ReanchorFrame> frames,
                                 const ReanchorBody& body,
                                 const Eigen::Matrix3d& R_ba) {
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  constexpr double kShapeOfPath_radii = 0.05;  // 1-sigma of the predicted path but for its offset
  // Priors of a compact body, 1-sigma: the distance of its visible face from the centre, and the
  // ratio of the extents of two aspects.
  constexpr double kNearFace_radii = 0.5;
  constexpr double kLikeExtents = 0.3;
  const auto weight = [](double sigma) { return 1.0 / (sigma * sigma); };
  const double shape_weight = weight(kShapeOfPath_radii * body.radius_mu);
  const Pose& last = frames.back().predicted;
  const Eigen::Vector3d near_face_T =
      body.centre_T +
      kNearFace_radii * body.radius_mu * (last.camera_T() - body.centre_T).normalized();
  Vector7 weights;
  weights << weight(kLikeExtents),
      Eigen::Vector3d::Constant(weight(kNearFace_radii * body.radius_mu)),
      Eigen::Vector3d::Constant(weight(frames.front().predicted_sigma_mu));
  Vector7 expected;
  expected << 1.0, near_face_T, Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 7, 7> normal = weights.asDiagonal();
  Vector7 right = weights.cwiseProduct(expected);
  for (const ReanchorFrame& frame : frames) {
    Eigen::Matrix<double, 3, 7> row;
    row << frame.start.p_CT, -frame.start.R_CT * R_ba.transpose(), Eigen::Matrix3d::Identity();
    normal += shape_weight * row.transpose() * row;
    right += shape_weight * row.transpose() * frame.predicted.p_CT;
  }
  return normal.ldlt().solve(right).head<4>();
}

}  // namespace

Result<Reanchoring> reanchor_map(std::span<const ReanchorFrame> frames, const ReanchorBody& body) {
  constexpr std::size_t kFramesMin = 3;  // with two the path has no check
  if (frames.size() < kFramesMin) {
    return ErrorCode::kTooFewObservations;
  }
  const bool sigmas = std::all_of(frames.begin(), frames.end(), [](const ReanchorFrame& f) {
    return std::isfinite(f.predicted_sigma_rad) && f.predicted_sigma_rad > 0.0 &&
           std::isfinite(f.predicted_sigma_mu) && f.predicted_sigma_mu > 0.0;
  });
  if (!sigmas || !(body.radius_mu > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  Reanchoring reanchoring;
  reanchoring.to_T.R_ba = mean_rotation(frames);
  const Eigen::Vector4d found = scale_and_origin(frames, body, reanchoring.to_T.R_ba);
  if (!(found(0) > 0.0) || !found.allFinite()) {
    return ErrorCode::kDegenerate;
  }
  reanchoring.to_T.scale = found(0);
  reanchoring.to_T.t_ba = found.tail<3>();
  check_attitudes(frames, &reanchoring);
  return reanchoring;
}

}  // namespace polhode
