#include "pipeline/smooth.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <memory>
#include <optional>

#include "geometry/reprojection.hpp"
#include "map/grow.hpp"
#include "map/landmarks.hpp"
#include "map/track.hpp"
#include "map/window.hpp"
#include "motion/rates.hpp"
#include "pipeline/camera_job.hpp"
#include "pipeline/counting.hpp"
#include "pipeline/map_update.hpp"
#include "pipeline/results.hpp"
#include "pipeline/row_times.hpp"
#include "pipeline/state.hpp"
#include "shape/scale_reading.hpp"

namespace polhode {
namespace {

constexpr int kInliersMin = 12;  // the default of localise.inliers_min

std::vector<PoseObservation> observations_of(const Keyframe& keyframe,
                                             const Map& map,
                                             const CameraModel& camera) {
  std::vector<PoseObservation> observations;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    if (id.valid()) {
      const Feature& f = keyframe.features[i];
      observations.push_back(
          {.p_T = map.landmarks[id.index()].p_T,
           .normalised = f.normalised,
           .sigma_normalised = static_cast<double>(f.sigma_px) / camera.focal_px()});
    }
  }
  return observations;
}

SmoothedPose refine(const std::vector<PoseObservation>& observations, const Pose& hint) {
  SmoothedPose smoothed;
  smoothed.matches = static_cast<int>(observations.size());
  if (smoothed.matches < kInliersMin) {
    return smoothed;
  }
  std::vector<std::uint8_t> inlier(observations.size(), 1);
  const Result<AbsolutePose> refined = refine_pose(observations, hint, inlier);
  if (refined) {
    smoothed.valid = true;
    smoothed.absolute = refined.value();
  }
  return smoothed;
}

/// Information of each landmark slot: the sum over its observations in keyframes. Zero without any.
std::vector<Eigen::Matrix3d> information_of_landmarks(const Map& map, const CameraModel& camera) {
  std::vector<Eigen::Matrix3d> information(map.landmarks.size(), Eigen::Matrix3d::Zero());
  for (const Keyframe& keyframe : map.keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      if (!id.valid()) {
        continue;
      }
      const double w = camera.focal_px() / static_cast<double>(keyframe.features[i].sigma_px);
      const Eigen::Matrix<double, 2, 3> J =
          w * projection_jacobian(keyframe.pose, map.landmarks[id.index()].p_T).rightCols<3>() *
          keyframe.pose.R_CT;
      information[id.index()] += J.transpose() * J;
    }
  }
  return information;
}

const Keyframe* keyframe_of(const Map& map, std::uint32_t frame) {
  const auto found = std::find_if(map.keyframes.begin(),
                                  map.keyframes.end(),
                                  [&](const Keyframe& k) { return k.used && k.frame == frame; });
  return found == map.keyframes.end() ? nullptr : &*found;
}

}  // namespace

void bring_to_rest(Component* component) {
  // Without a deadline: each round searches observations once more, and 50 iterations converge.
  constexpr int kRounds = 3;
  constexpr int kIterations = 50;
  Component::State* s = ComponentAccess::state(*component);
  MapState& mapping = s->mapping;
  const CameraModel& camera = s->configuration.camera;
  close_jobs(s);
  for (int round = 0; round < kRounds && mapping.map.keyframe_count > 1; ++round) {
    adjust_all(kIterations, s);
    cull_misfits(camera, &mapping);
    refresh_landmarks(&mapping.map, camera);
    if (round + 1 < kRounds) {
      extend_landmarks(0, camera, &mapping.map);
      refresh_landmarks(&mapping.map, camera);
    }
  }
  take_counts(&mapping.counts, &s->jobs.counts, &s->counters);
}

CameraFit test_camera_at_rest(Component* component) {
  // Chosen: a second or two of work, and the sigma of a sweep of a right angle stays at a per cent.
  constexpr BundleOptions kOptions{
      .iterations_max = 100, .cauchy_sigma = 2.0, .observations_max = 6000};
  constexpr int kKeyframesMin = 6;  // fewer hold a map of any depth
  Component::State* s = ComponentAccess::state(*component);
  if (s->mapping.map.keyframe_count < kKeyframesMin) {
    return {};
  }
  const auto snapshot = std::make_unique<AdjustmentSnapshot>();
  snapshot_all(s->mapping.map, s->configuration.camera, snapshot.get());
  const MapMotions motions = motions_of(*snapshot);
  CameraFit fit =
      adjust_camera(camera_problem_of(motions, s->configuration.camera, snapshot.get()), kOptions);
  take_camera_test(fit, &s->camera);
  return fit;
}

MapAtRest::MapAtRest(Component* component)
    : state_(ComponentAccess::state(*component)),
      slot_of_number_(static_cast<std::size_t>(state_->mapping.map.next_landmark_number), -1) {
  const auto& landmarks = state_->mapping.map.landmarks;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (landmarks[i].used) {
      slot_of_number_[static_cast<std::size_t>(landmarks[i].number)] = static_cast<std::int32_t>(i);
    }
  }
}

SmoothedPose MapAtRest::from_log(std::uint32_t frame,
                                 const Pose& hint,
                                 std::span<const Observation> inliers) const {
  const Map& map = state_->mapping.map;
  const CameraModel& camera = state_->configuration.camera;
  if (const Keyframe* keyframe = keyframe_of(map, frame)) {
    SmoothedPose smoothed = refine(observations_of(*keyframe, map, camera), keyframe->pose);
    smoothed.absolute.pose = keyframe->pose;
    smoothed.valid = smoothed.valid && smoothed.matches >= kInliersMin;
    return smoothed;
  }
  std::vector<PoseObservation> observations;
  for (const Observation& o : inliers) {
    const bool known =
        o.landmark >= 0 && static_cast<std::size_t>(o.landmark) < slot_of_number_.size();
    const std::int32_t slot = known ? slot_of_number_[static_cast<std::size_t>(o.landmark)] : -1;
    if (slot >= 0) {
      observations.push_back(
          {.p_T = map.landmarks[static_cast<std::size_t>(slot)].p_T,
           .normalised = Eigen::Vector2d(o.normalised[0], o.normalised[1]),
           .sigma_normalised = static_cast<double>(o.sigma_px) / camera.focal_px()});
    }
  }
  return refine(observations, hint);
}

SmoothedPose MapAtRest::from_image(const Frame& frame) {
  Component::State* s = state_;
  const Configuration& c = s->configuration;
  forget_frame(&s->mapping, &s->picture, &s->features);
  if (bring_picture(frame, c.camera, &s->mapping.reference, &s->picture) != FrameUse::kUsed) {
    return {};
  }
  find_target(s->picture.gray, c.parameters.mask, &s->picture.mask);
  s->features.image_motion = expected_image_motion(frame.timestamp_ns, *s);
  detect_once(s->picture, s->configuration, s->steps_to_shed > 0, s->timer, &s->features);
  // With a busy background the target has too few features for matching over the whole map. The
  // motion predicts its pose, but only for an observer with constant attitude.
  const auto expected =
      s->motion.observer_known
          ? std::nullopt
          : pose_by_joint_model(s->motion, c.parameters.motion, frame.timestamp_ns, s->motion.R_IC);
  const MapInput input = map_input(*s);
  SmoothedPose smoothed;
  // The model was fitted over this time, so nothing is extrapolated from the last pose.
  const auto prior =
      expected ? std::optional(ExpectedPose{.prediction = *expected,
                                            .poses_since_start = s->motion.poses_since_start})
               : std::nullopt;
  if ((prior && find_about(input, *prior, &s->mapping)) ||
      (relocalise_frame(input, &s->mapping) && (!prior || plausible(*prior, true, s->mapping)) &&
       !is_ambiguous(input, prior, &s->mapping))) {
    smoothed.valid = true;
    smoothed.absolute = s->mapping.localised.absolute;
    smoothed.matches = static_cast<int>(s->mapping.localised.matches.size());
  }
  return smoothed;
}

bool read_scale_in_keyframe(Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  return count(read_scale_in_keyframe(s->mapping, scale_input(*s), &s->scale), &s->counters);
}

bool read_scale_in_image(Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  return count(read_scale_in_frame(s->mapping, scale_input(*s), &s->scale), &s->counters);
}

bool read_scale_in_shape(const Shape& shape, Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  const ScaleOptions& options = s->configuration.parameters.scale;
  return count(read_scale_of(shape, options, &s->scale), &s->counters);
}

ConfirmedLandmarks confirmed_landmarks(const Map& map, const CameraModel& camera) {
  ConfirmedLandmarks found;
  const std::vector<Eigen::Matrix3d> information = information_of_landmarks(map, camera);
  const double noise_scale = std::max(1.0, residual_scale(map, camera));
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const Landmark& landmark = map.landmarks[i];
    if (landmark.used && confirmed(landmark)) {
      found.points_T.push_back(landmark.p_T);
      found.numbers.push_back(landmark.number);
      found.directions_T.push_back(landmark.normal_T.normalized());
      found.views.push_back(landmark.observations);
      found.sigmas.push_back(noise_scale * worst_sigma(information[i].inverse()));
    }
  }
  return found;
}

}  // namespace polhode
