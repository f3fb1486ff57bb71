#include "map/blob_agreement.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace polhode {
namespace {

/// The landmark's view that looks most like a feature; null where their keyframes are gone.
const LandmarkView* most_alike(const Map& map, const Landmark& landmark, const Feature& feature) {
  const LandmarkView* alike = nullptr;
  int least = std::numeric_limits<int>::max();
  for (const LandmarkView& view : landmark.views) {
    const int distance = distance2(view.descriptor, feature.descriptor);
    if (distance < least && feature_of_view(map, view) != nullptr) {
      least = distance;
      alike = &view;
    }
  }
  return alike;
}

/// Where a view's orientation points in the image of another pose, a unit vector: it lies in the
/// surface.
Eigen::Vector2d direction_from(const Map& map,
                               const Pose& pose,
                               const Landmark& landmark,
                               const LandmarkView& view) {
  constexpr double kStep = 1e-3;  // small against any body in the image, in the plane z = 1
  const Pose& seen_by = map.keyframes[view.keyframe.index()].pose;
  const Eigen::Vector3d p_C = seen_by.to_camera(landmark.p_T);
  const Eigen::Vector3d normal_C = seen_by.R_CT * landmark.normal_T;
  const auto angle_rad = static_cast<double>(feature_of_view(map, view)->angle_rad);
  const Eigen::Vector2d step = kStep * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  const Eigen::Vector3d ray = (p_C.hnormalized() + step).homogeneous();
  const Eigen::Vector3d beside_C = normal_C.dot(p_C) / normal_C.dot(ray) * ray;
  const Eigen::Vector3d beside_T = seen_by.R_CT.transpose() * (beside_C - seen_by.p_CT);
  return (pose.to_camera(beside_T).hnormalized() - pose.to_camera(landmark.p_T).hnormalized())
      .normalized();
}

}  // namespace

int agreeing_blobs(const LocaliseInput& input, const LocalisedFrame& frame) {
  constexpr double kCosineMin = 0.94;  // 20 deg: 2 sigma of a blob's orientation in other light
  constexpr double kLogSize = 0.35;    // half an octave: one step of the scales
  const Pose& pose = frame.absolute.pose;
  int agreeing = 0;
  for (const LandmarkMatch& match : frame.matches) {
    const Landmark& landmark = input.map->landmarks[match.landmark.index()];
    if (!match.inlier || match.feature < 0) {
      continue;
    }
    const Feature& feature = (*input.features)[static_cast<std::size_t>(match.feature)];
    const LandmarkView* const view = most_alike(*input.map, landmark, feature);
    if (view == nullptr) {
      continue;
    }
    const double size_px =
        landmark.size_mu * input.camera->focal_px() / pose.to_camera(landmark.p_T).z();
    const auto angle_rad = static_cast<double>(feature.angle_rad);
    const double cosine = direction_from(*input.map, pose, landmark, *view)
                              .dot(Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad)));
    const double log_size = std::log(static_cast<double>(feature.scale_px) / size_px);
    agreeing += cosine > kCosineMin && std::abs(log_size) < kLogSize ? 1 : 0;
  }
  return agreeing;
}

}  // namespace polhode
