#include "pipeline/smooth.hpp"

#include <algorithm>
#include <optional>

#include "map/landmarks.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/results.hpp"
#include "pipeline/state.hpp"
#include "pipeline/track.hpp"

namespace polhode {
namespace {

constexpr int kInliersMin = 12;

/// The observations of a keyframe are its sightings.
std::vector<PoseObservation> sightings_of(const Keyframe& keyframe, const Component::State& s) {
  std::vector<PoseObservation> observations;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    if (id.valid()) {
      const Feature& f = keyframe.features[i];
      observations.push_back(
          {.p_T = s.map.landmarks[id.index()].p_T,
           .normalised = f.normalised,
           .sigma_normalised = static_cast<double>(f.sigma_px) / s.camera.focal_px()});
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

const Keyframe* keyframe_of(const Component::State& s, std::uint32_t frame) {
  const auto found = std::find_if(s.map.keyframes.begin(),
                                  s.map.keyframes.end(),
                                  [&](const Keyframe& k) { return k.used && k.frame == frame; });
  return found == s.map.keyframes.end() ? nullptr : &*found;
}

}  // namespace

void bring_to_rest(Component::State* s) {
  constexpr int kRounds = 3;
  constexpr int kIterations = 50;
  close_jobs(s);
  for (int round = 0; round < kRounds && s->map.keyframe_count > 1; ++round) {
    adjust_all(kIterations, s);
    cull_map(s);
    refresh_landmarks(&s->map, s->camera);
    if (round + 1 < kRounds) {
      extend_landmarks(0, s->camera, &s->map);
      refresh_landmarks(&s->map, s->camera);
    }
  }
}

MapAtRest::MapAtRest(Component::State* state)
    : state_(state),
      slot_of_number_(static_cast<std::size_t>(state->map.next_landmark_number), -1) {
  for (std::size_t i = 0; i < state->map.landmarks.size(); ++i) {
    if (state->map.landmarks[i].used) {
      slot_of_number_[static_cast<std::size_t>(state->map.landmarks[i].number)] =
          static_cast<std::int32_t>(i);
    }
  }
}

SmoothedPose MapAtRest::from_log(std::uint32_t frame,
                                 const Pose& hint,
                                 std::span<const Observation> inliers) const {
  if (const Keyframe* keyframe = keyframe_of(*state_, frame)) {
    SmoothedPose smoothed = refine(sightings_of(*keyframe, *state_), keyframe->pose);
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
          {.p_T = state_->map.landmarks[static_cast<std::size_t>(slot)].p_T,
           .normalised = undistort(state_->camera,
                                   {static_cast<double>(o.u_px), static_cast<double>(o.v_px)}),
           .sigma_normalised = static_cast<double>(o.sigma_px) / state_->camera.focal_px()});
    }
  }
  return refine(observations, hint);
}

SmoothedPose MapAtRest::from_image(const Frame& frame) {
  Component::State* s = state_;
  forget_picture(s);
  if (bring_picture(frame, s) != FrameUse::kUsed) {
    return {};
  }
  find_target(s->gray, s->parameters.mask, &s->mask);
  // A busy background leaves the target too few features to be found among all: the motion knows
  // where it was, as seen by an observer who stands still.
  const auto expected =
      s->motion.observer_known
          ? std::nullopt
          : pose_by_map_model(s->motion, s->parameters.motion, frame.timestamp_ns, s->motion.R_IC);
  SmoothedPose smoothed;
  if ((expected && find_about(*expected, s)) || relocalise_frame(s)) {
    smoothed.valid = true;
    smoothed.absolute = s->localised.absolute;
    smoothed.matches = static_cast<int>(s->localised.matches.size());
  }
  return smoothed;
}

ConfirmedLandmarks confirmed_landmarks(const Component::State& s) {
  ConfirmedLandmarks found;
  for (const Landmark& landmark : s.map.landmarks) {
    if (landmark.used && confirmed(landmark)) {
      found.points_T.push_back(landmark.p_T);
      found.numbers.push_back(landmark.number);
    }
  }
  return found;
}

}  // namespace polhode
