#include "shape/scale_reading.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/reprojection.hpp"
#include "map/track.hpp"

namespace polhode {
namespace {

/// Landmarks seen in a frame, and their sigmas along the rays.
struct SeenLandmarks {
  FixedVector<LandmarkId, limits::kFeatures> ids;
  FixedVector<Eigen::Vector3d, limits::kFeatures> points_T;
  FixedVector<double, limits::kFeatures> sigmas_mu;
};

void add(LandmarkId id, const Map& map, SeenLandmarks* seen) {
  if (seen->ids.push_back(id)) {
    (void)seen->points_T.push_back(map.landmarks[id.index()].p_T);
  }
}

using InformationTable = FixedVector<Eigen::Matrix3d, limits::kFeatures>;

/// Sigma of each landmark seen, by all its observations in keyframes.
void collect_information(const Map& map,
                         const CameraModel& camera,
                         const SeenLandmarks& seen,
                         InformationTable* information) {
  constexpr std::int32_t kNotSeen = -1;  // no place in the table
  std::array<std::int32_t, limits::kLandmarks> place_of{};
  place_of.fill(kNotSeen);
  for (std::size_t i = 0; i < seen.ids.size(); ++i) {
    place_of[seen.ids[i].index()] = static_cast<std::int32_t>(i);
    (void)information->push_back(Eigen::Matrix3d::Zero());
  }
  for (const Keyframe& keyframe : map.keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      const std::int32_t place = id.valid() ? place_of[id.index()] : kNotSeen;
      if (place == kNotSeen) {
        continue;
      }
      const double w = camera.focal_px() / static_cast<double>(keyframe.features[i].sigma_px);
      const Eigen::Matrix<double, 2, 3> J =
          w * projection_jacobian(keyframe.pose, map.landmarks[id.index()].p_T).rightCols<3>() *
          keyframe.pose.R_CT;
      (*information)[static_cast<std::size_t>(place)] += J.transpose() * J;
    }
  }
}

/// A landmark whose depth the keyframes do not determine gets the map's size as its sigma.
void collect_sigmas(const Pose& pose,
                    const Map& map,
                    const CameraModel& camera,
                    SeenLandmarks* seen) {
  InformationTable information;
  collect_information(map, camera, *seen, &information);
  for (std::size_t i = 0; i < information.size(); ++i) {
    const Eigen::Vector3d ray_T =
        pose.R_CT.transpose() * pose.to_camera(seen->points_T[i]).normalized();
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(information[i]);
    const double variance = ray_T.dot(ldlt.solve(ray_T));
    const bool fixed = ldlt.info() == Eigen::Success && variance >= 0.0 &&
                       variance < map.radius_mu * map.radius_mu;
    (void)seen->sigmas_mu.push_back(fixed ? std::sqrt(variance) : map.radius_mu);
  }
}

ScaleChange read_in(const Pose& pose,
                    const MapState& state,
                    const ScaleInput& input,
                    SeenLandmarks* seen,
                    ScaleState* scale) {
  collect_sigmas(pose, state.map, *input.camera, seen);
  return read_scale_in({.pose = pose,
                        .landmarks_T = seen->points_T.view(),
                        .sigmas_mu = seen->sigmas_mu.view(),
                        .relief_sigma = turn_sigma(state.drift)},
                       *input.options,
                       *input.camera,
                       state.map.next_keyframe_number,
                       scale);
}

/// Whether an earlier reading gave the scale, and the map has grown since.
bool is_repeated(std::uint32_t next_keyframe, const ScaleState& scale) {
  return scale.known && scale.keyframes_at_reading > 0 && has_grown(next_keyframe, scale);
}

}  // namespace

ScaleChange read_scale_in_frame(const MapState& map, const ScaleInput& input, ScaleState* scale) {
  SeenLandmarks seen;
  for (const LandmarkMatch& match : map.localised.matches) {
    if (match.inlier && map.map.landmarks[match.landmark.index()].used) {
      add(match.landmark, map.map, &seen);
    }
  }
  return read_in(map.localised.absolute.pose, map, input, &seen, scale);
}

ScaleChange read_scale_in_keyframe(const MapState& map,
                                   const ScaleInput& input,
                                   ScaleState* scale) {
  for (const Keyframe& keyframe : map.map.keyframes) {
    if (keyframe.used && keyframe.timestamp_ns == input.options->frame_timestamp_ns) {
      SeenLandmarks seen;
      for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
        if (keyframe.landmark_of[i].valid()) {
          add(keyframe.landmark_of[i], map.map, &seen);
        }
      }
      return read_in(keyframe.pose, map, input, &seen, scale);
    }
  }
  return {};
}

ScaleChange read_scale(std::int64_t timestamp_ns,
                       const MapState& map,
                       const ScaleInput& input,
                       ScaleState* scale) {
  if (!names_frame(*input.options) ||
      !frame_reading_is_due(*input.options, map.map.next_keyframe_number, *scale)) {
    return {};
  }
  const bool repeated = is_repeated(map.map.next_keyframe_number, *scale);
  const double sigma_before = scale->relative_sigma;
  const ScaleChange change = timestamp_ns == input.options->frame_timestamp_ns
                                 ? read_scale_in_frame(map, input, scale)
                                 : read_scale_in_keyframe(map, input, scale);
  if (repeated && !(change.read && scale->relative_sigma < sigma_before)) {
    ++scale->not_improved;
    scale->keyframes_at_reading = map.map.next_keyframe_number;
  }
  return change;
}

}  // namespace polhode
