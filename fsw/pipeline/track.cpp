#include "pipeline/track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"
#include "map/keyframes.hpp"
#include "pipeline/acquire.hpp"
#include "pipeline/jobs.hpp"
#include "pipeline/localise_input.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/picture.hpp"

namespace polhode {
namespace {

constexpr std::size_t kPosesTried = 6;  // that many poses have checked a motion

/// Fewer poses than that have checked the motion. @param start_checks  the start's poses among
/// them.
bool is_young(const PosePrediction& predicted, bool start_checks, const Component::State& s) {
  return predicted.rotation_poses < kPosesTried ||
         (!start_checks && s.motion.poses_since_start < kPosesTried);
}

int last_inliers(const Component::State& s) { return static_cast<int>(s.reference.points.size()); }

/// A side has come back, and its old landmarks carry the pose: then the drift of the young ones,
/// not the body, has jumped.
bool comes_back(const Component::State& s) {
  constexpr int kOldMin = 30;  // as for a closed loop
  int old = 0;
  int old_inliers = 0;
  for (const LandmarkMatch& match : s.localised.matches) {
    const Landmark& landmark = s.map.landmarks[match.landmark.index()];
    if (is_old(landmark, s.map)) {
      ++old;
      old_inliers += match.inlier ? 1 : 0;
    }
  }
  return old_inliers >= kOldMin && 2 * old_inliers >= old;
}

/// Most keyframes are never followed, and most frames not by flow: pyramids are built for those
/// that are.
void ensure_pyramids(Component::State* s) {
  if (!s->reference.pyramid.built) {
    build_pyramid(s->reference.gray, &s->reference.pyramid);
  }
  build_pyramid(s->gray, &s->pyramid);
  stage_done(Stage::kTracks, *s);
}

/// By optical flow, when the prediction says that the picture moves and the body turns little.
/// Edges slide along themselves, glints and what is behind the rim stay where they are while the
/// body turns: from a patch that was taken more than a degree ago flow finds poses that lag, by up
/// to 3 deg, all of a narrow side's landmarks alike. What it finds must agree with the motion so
/// far.
bool try_flow(const PosePrediction& predicted, Component::State* s) {
  constexpr double kTurnMost_rad =
      0.0175;  // less than makes a keyframe, which needs features anyway
  if (!s->reference.valid ||
      rotation_angle_rad(s->reference.pose.R_CT, predicted.pose.R_CT) > kTurnMost_rad ||
      predicted_motion_px(s->reference, predicted.pose, s->map, s->camera) >
          s->parameters.tracks.small_motion_max_px) {
    return false;
  }
  ensure_pyramids(s);
  const Result<bool> done = localise_by_flow(localise_input(*s),
                                             s->reference,
                                             s->pyramid,
                                             s->parameters.tracks,
                                             predicted.pose,
                                             &s->localise_scratch,
                                             &s->localised);
  return done.ok() && 2 * s->localised.absolute.inliers >= last_inliers(*s) &&
         plausible(predicted, true, *s);
}

/// A mismatch within the smallest circle (4 px) falls within 4 sigma (1 px) of its landmark by
/// chance one time in 16. Twice that many inliers are beyond chance; how many landmarks should be
/// seen says less, since a map holds more of them than a single frame has features.
bool agrees(const LocalisedFrame& localised, int inliers_min) {
  return localised.absolute.inliers >= inliers_min + static_cast<int>(localised.matches.size()) / 8;
}

/// So many inliers, and so little else, that the pose stands by itself whatever the motion so far
/// says. Foil that stays where it is while the body turns carried wrong poses with half of the
/// matches; right ones on textured bodies have two thirds and more.
bool certain(const LocalisedFrame& localised) {
  constexpr int kInliersMin = 30;
  return localised.absolute.inliers >= kInliersMin &&
         5 * localised.absolute.inliers >= 3 * static_cast<int>(localised.matches.size());
}

/// Agrees with the motion, or need not.
bool believable(const PosePrediction& predicted, bool start_checks, const Component::State& s) {
  return plausible(predicted, start_checks, s) || comes_back(s) || certain(s.localised);
}

/// A side may show little of a turn; the motion, where it is known together with the map, knows the
/// rest. A measurement that contradicts it stands by itself.
void fuse_with_motion(Component::State* s) {
  const AbsolutePose& measured = s->localised.absolute;
  const auto prior =
      pose_by_map_model(s->motion, s->parameters.motion, s->timestamp_ns, s->motion.R_IC);
  if (!prior) {
    return;
  }
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  Vector6 apart;
  apart << so3_log(measured.pose.R_CT * prior->pose.R_CT.transpose()),
      measured.pose.p_CT - prior->pose.p_CT;
  const PoseCovariance sum = prior->covariance + measured.covariance;
  const Eigen::LDLT<PoseCovariance> factor(sum);
  constexpr double kChi2Max = 22.5;  // 99.9 % of six numbers
  if (factor.info() != Eigen::Success || !(apart.dot(factor.solve(apart)) < kChi2Max)) {
    return;
  }
  const PoseCovariance by_sum = factor.solve(prior->covariance);  // transposed gain
  const Vector6 step = by_sum.transpose() * apart;
  const PoseCovariance covariance = prior->covariance - by_sum.transpose() * prior->covariance;
  take_pose({.R_CT = so3_exp(step.head<3>()) * prior->pose.R_CT,
             .p_CT = prior->pose.p_CT + step.tail<3>()},
            0.5 * (covariance + covariance.transpose()),
            &s->localise_scratch,
            &s->localised);
}

void renew_reference(Component::State* s) {
  s->reference.valid = true;
  s->reference_frame = s->frame;
  std::swap(s->reference.pyramid, s->pyramid);
  s->reference.gray_to_come = !s->reference.pyramid.built;
  s->reference.pose = s->localised.absolute.pose;
  s->reference.points.clear();
  for (const LandmarkMatch& match : s->localised.matches) {
    if (match.inlier && s->map.landmarks[match.landmark.index()].used) {
      (void)s->reference.points.push_back(match);
    }
  }
}

/// Flow can find only what it followed.
void count_sightings(Component::State* s) {
  for (const LandmarkMatch& match : s->localised.matches) {
    Landmark& landmark = s->map.landmarks[match.landmark.index()];
    landmark.predicted += s->features_ready ? 0 : 1;
    landmark.found += match.inlier ? 1 : 0;
  }
  if (!s->features_ready) {
    return;
  }
  for (Landmark& landmark : s->map.landmarks) {
    Eigen::Vector2d pixel;
    if (landmark.used && should_be_seen(landmark, s->localised.absolute.pose, s->camera, &pixel)) {
      ++landmark.predicted;
    }
  }
}

/// A frame followed by flow that is to become a keyframe needs features, and landmarks tied to
/// them.
/// @return false, the pose by flow as it was, where the features do not bear it out.
bool bring_features(Component::State* s) {
  if (s->features_ready) {
    return true;
  }
  ensure_features(s);
  LocalisedFrame& by_features = s->closure;  // no loop is being closed yet
  const Result<bool> done = localise_guided(localise_input(*s),
                                            s->localised.absolute.pose,
                                            s->parameters.localise.search_floor_px,
                                            &s->localise_scratch,
                                            &by_features);
  if (!done || !agrees(by_features, s->parameters.localise.inliers_min)) {
    return false;
  }
  s->localised = by_features;
  fuse_with_motion(s);
  return true;
}

/// Takes out what the keyframe's outline rules out: it makes no landmarks. What is tied to one
/// stays.
void veto_features(Component::State* s) {
  if (!s->mask_state.sharp) {
    return;  // nothing is ruled out, and features are large to move
  }
  std::array<std::int32_t, limits::kFeatures> now_at{};
  now_at.fill(-1);
  for (const LandmarkMatch& match : s->localised.matches) {
    if (match.inlier && match.feature >= 0) {
      now_at[static_cast<std::size_t>(match.feature)] = 0;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s->features.size(); ++i) {
    const Feature& feature = s->features[i];
    if (now_at[i] == 0 || !rules_out(s->mask_state, feature.u_px, feature.v_px)) {
      now_at[i] = static_cast<std::int32_t>(kept);
      s->features[kept++] = feature;
    }
  }
  s->features.resize(kept);
  for (LandmarkMatch& match : s->localised.matches) {
    match.feature = match.feature >= 0 ? now_at[static_cast<std::size_t>(match.feature)] : -1;
  }
}

void lose(Component::State* s) {
  s->reference.valid = false;
  if (s->mode == Mode::kTracking) {
    ++s->counters.lost;
    clear(&s->initialisation.tracks);
    give_up_start(s);
  }
  s->mode = Mode::kLost;
}

void hold(Component::State* s) {
  s->pose_valid = true;
  s->counters.relocalised += s->mode == Mode::kLost ? 1 : 0;
  s->mode = Mode::kTracking;
}

}  // namespace

bool plausible(const PosePrediction& predicted, bool start_checks, const Component::State& s) {
  constexpr std::size_t kPosesMin = 3;  // two give a rate without a check
  if (predicted.rotation_poses < kPosesMin) {
    return true;
  }
  constexpr double kDepthError = 0.05;
  constexpr double kAllowance_rad = 0.0175;
  const AbsolutePose& found = s.localised.absolute;
  const double step_rad =
      rotation_angle_rad(last_pose_seen(s.motion, s.motion.R_IC).R_CT, predicted.pose.R_CT);
  const double sigma_rad =
      std::sqrt(predicted.covariance.topLeftCorner<3, 3>().diagonal().maxCoeff() +
                found.covariance.topLeftCorner<3, 3>().diagonal().maxCoeff());
  const double bound_rad = is_young(predicted, start_checks, s)
                               ? step_rad * step_rad + 3.0 * sigma_rad + kAllowance_rad
                               : kDepthError * step_rad + 4.0 * sigma_rad;
  return rotation_angle_rad(found.pose.R_CT, predicted.pose.R_CT) < bound_rad + s.map_moved_rad;
}

bool find_about(const PosePrediction& predicted, Component::State* s) {
  ensure_features(s);
  const double body_px = s->map.radius_mu * s->camera.focal_px() / predicted.pose.p_CT.z();
  // The rotation of one frame to the next is predicted to about a tenth; three circles bracket what
  // that leaves.
  const double first_px = std::max(s->parameters.localise.search_floor_px, 0.04 * body_px);
  // What agrees with the start, in whichever circle, goes before what may contradict it.
  for (const bool start_checks : {true, false}) {
    if (!start_checks && is_young(predicted, true, *s) == is_young(predicted, false, *s)) {
      break;  // the same again
    }
    double radius_px = first_px;
    for (int i = 0; i < 3; ++i, radius_px *= 3.0) {
      const Result<bool> done = localise_guided(
          localise_input(*s), predicted.pose, radius_px, &s->localise_scratch, &s->localised);
      if (done && agrees(s->localised, s->parameters.localise.inliers_min) &&
          believable(predicted, start_checks, *s)) {
        return true;
      }
    }
  }
  return false;
}

bool relocalise_frame(Component::State* s) {
  ensure_features(s);
  const Result<bool> done = relocalise(localise_input(*s), &s->localise_scratch, &s->localised);
  constexpr int kInliersMin = 30;
  return done && s->localised.absolute.inliers >= kInliersMin &&
         2 * s->localised.absolute.inliers >= static_cast<int>(s->localised.matches.size());
}

void track(const std::optional<PosePrediction>& predicted, Component::State* s) {
  const bool found = predicted && (try_flow(*predicted, s) || find_about(*predicted, s));
  const bool everywhere =
      !found && relocalise_frame(s) && (!predicted || believable(*predicted, false, *s));
  if (!found && !everywhere) {
    lose(s);
    collect(s);
    return;
  }
  check_pose(s->timestamp_ns,
             s->localised.absolute.pose,
             s->localised.absolute.covariance,
             s->drift,
             &s->motion);
  fuse_with_motion(s);
  const bool may_teach = s->verdict.decision == FrameDecision::kUse;
  if (may_teach) {
    count_sightings(s);
  }
  if (may_teach && may_extend_map(*s) && bring_features(s)) {
    stage_done(Stage::kMap, *s);
    sharpen_outline(&s->mask_state);
    veto_features(s);
    stage_done(Stage::kMask, *s);
    extend_map(s);
    renew_reference(s);
  } else if (!s->reference.valid) {
    renew_reference(s);
  }
  hold(s);
}

}  // namespace polhode
