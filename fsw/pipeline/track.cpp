#include "pipeline/track.hpp"

#include <algorithm>
#include <cmath>

#include "map/keyframes.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/picture.hpp"

namespace polhode {
namespace {

int last_inliers(const Component::State& s) { return static_cast<int>(s.reference.points.size()); }

/// By optical flow, when the prediction says that the picture moves little.
bool try_flow(const Pose& predicted, Component::State* s) {
  if (!s->reference.valid ||
      predicted_motion_px(s->reference, predicted, s->map, s->camera) > s->parameters.tracks.small_motion_max_px) {
    return false;
  }
  const Result<bool> done = localise_by_flow(localise_input(*s), s->reference, s->pyramid, s->parameters.tracks,
                                             predicted, &s->localise_scratch, &s->localised);
  return done.ok() && 2 * s->localised.absolute.inliers >= last_inliers(*s);
}

/// By descriptors about the predicted pose, in a circle that grows when too few agree.
bool try_guided(const Pose& predicted, Component::State* s) {
  ensure_features(s);
  const double body_px = s->map.radius_mu * s->camera.focal_px() / predicted.p_CT.z();
  // The rotation of one frame to the next is predicted to about a tenth; three circles bracket what that leaves.
  const double first_px = std::max(s->parameters.localise.search_floor_px, 0.04 * body_px);
  double radius_px = first_px;
  for (int i = 0; i < 3; ++i, radius_px *= 3.0) {
    const Result<bool> done =
        localise_guided(localise_input(*s), predicted, radius_px, &s->localise_scratch, &s->localised);
    if (done && 4 * s->localised.absolute.inliers >= s->localised.predicted) {
      return true;
    }
  }
  return false;
}

void renew_reference(Component::State* s) {
  s->reference.valid = true;
  std::swap(s->reference.pyramid, s->pyramid);  // the next frame builds its own in the old one
  s->reference.pose = s->localised.absolute.pose;
  s->reference.points.clear();
  for (const LandmarkMatch& match : s->localised.matches) {
    if (match.inlier && s->map.landmarks[match.landmark.index()].used) {
      (void)s->reference.points.push_back(match);
    }
  }
}

void count_sightings(Component::State* s) {
  for (Landmark& landmark : s->map.landmarks) {
    Eigen::Vector2d pixel;
    if (landmark.used && should_be_seen(landmark, s->localised.absolute.pose, s->camera, &pixel)) {
      ++landmark.predicted;
    }
  }
  for (const LandmarkMatch& match : s->localised.matches) {
    if (match.inlier) {
      ++s->map.landmarks[match.landmark.index()].found;
    }
  }
}

/// A frame followed by flow that is to become a keyframe needs features, and landmarks tied to them.
bool bring_features(Component::State* s) {
  if (s->features_ready) {
    return true;
  }
  ensure_features(s);
  const Pose pose = s->localised.absolute.pose;
  return localise_guided(localise_input(*s), pose, s->parameters.localise.search_floor_px, &s->localise_scratch,
                         &s->localised)
      .ok();
}

void lose(Component::State* s) {
  s->reference.valid = false;
  if (s->mode == Mode::kTracking) {
    ++s->counters.lost;
  }
  s->mode = Mode::kLost;
  ++s->frames_lost;
}

void hold(bool by_relocalisation, Component::State* s) {
  s->pose_valid = true;
  if (s->mode == Mode::kLost) {
    s->counters.relocalised += by_relocalisation ? 1 : 0;
  }
  s->mode = Mode::kTracking;
  s->frames_lost = 0;
}

}  // namespace

LocaliseInput localise_input(const Component::State& s) {
  return {.map = &s.map,
          .features = &s.features,
          .camera = &s.camera,
          .options = &s.parameters.localise,
          .ratio_max = s.parameters.tracks.descriptor_ratio_max,
          .seed = s.parameters.seed,
          .stream = s.frame};
}

bool relocalise_frame(Component::State* s) {
  ensure_features(s);
  // A wrong pose would poison the map: more is asked than of a predicted one.
  constexpr int kInliersMin = 30;
  const Result<bool> done = relocalise(localise_input(*s), &s->localise_scratch, &s->localised);
  return done && s->localised.absolute.inliers >= kInliersMin &&
         2 * s->localised.absolute.inliers >= static_cast<int>(s->localised.matches.size());
}

bool predict_pose(const Component::State& s, PosePrediction* predicted) {
  if (s.poses.empty()) {
    return false;
  }
  const Result<PosePrediction> by_motion = predict_pose(s.poses.view(), s.timestamp_ns, s.parameters.motion);
  *predicted = by_motion ? by_motion.value() : PosePrediction{.pose = s.poses.back().pose};
  // Extrapolated through the camera: the last place is the better guess.
  if (!(predicted->pose.p_CT.z() > 0.1 * s.poses.back().pose.p_CT.z())) {
    predicted->pose.p_CT = s.poses.back().pose.p_CT;
  }
  return true;
}

void track(Component::State* s) {
  PosePrediction predicted;
  const bool has_prediction = predict_pose(*s, &predicted);
  const bool found = has_prediction && (try_flow(predicted.pose, s) || try_guided(predicted.pose, s));
  const bool everywhere = !found && relocalise_frame(s);
  if (!found && !everywhere) {
    lose(s);
    return;
  }
  count_sightings(s);
  if (wants_keyframe(s->map, s->localised.absolute.pose, s->localised.absolute.inliers, s->parameters.map)) {
    if (!bring_features(s)) {
      lose(s);
      return;
    }
    extend_map(s);
    renew_reference(s);
  } else if (!s->reference.valid) {
    renew_reference(s);
  }
  hold(everywhere, s);
}

}  // namespace polhode
