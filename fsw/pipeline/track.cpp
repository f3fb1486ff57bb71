#include "pipeline/track.hpp"

#include "map/grow.hpp"
#include "map/track.hpp"
#include "mask/follow.hpp"
#include "motion/disturbance.hpp"
#include "pipeline/acquire.hpp"
#include "pipeline/adjustment.hpp"
#include "pipeline/map_update.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

enum class FoundBy : std::uint8_t {
  kNothing,
  kFlow,
  kFeatures,
  kPrior,  ///< too few features for a pose of their own, consistent with the motion so far
};

/// This frame's pose, in `mapping.localised`.
FoundBy find_pose(const std::optional<ExpectedPose>& expected, Component::State* s) {
  MapState* mapping = &s->mapping;
  const bool followed = expected && follow_by_flow(map_input(*s), *expected, mapping);
  stage_done(Stage::kTracks, s->timer);
  if (followed) {
    return FoundBy::kFlow;
  }
  detect_once(s->picture, s->configuration, s->steps_to_shed > 0, s->timer, &s->features);
  const MapInput input = map_input(*s);
  const std::optional<ExpectedPose> from_departed = expected_from_departed(
      s->motion, mapping->drift, s->configuration.parameters.motion, s->clock.timestamp_ns);
  if ((expected && find_about(input, *expected, mapping)) ||
      (from_departed && find_about_inconsistent(input, *from_departed, mapping)) ||
      (relocalise_frame(input, mapping) && (!expected || believable(*expected, false, *mapping)) &&
       !is_ambiguous(input, expected, mapping))) {
    return FoundBy::kFeatures;
  }
  if (!expected && recognise_frame(input, mapping)) {
    // Its uncertainty is common to all later poses, as they and the map build on this one.
    const PoseCovariance& open = mapping->localised.absolute.covariance;
    add_reanchoring(worst_sigma(open.topLeftCorner<3, 3>()),
                    worst_sigma(open.bottomRightCorner<3, 3>()),
                    mapping->map.next_keyframe_number,
                    &mapping->drift);
    return FoundBy::kFeatures;
  }
  if (!has_target(s->mode) || !expected) {
    return FoundBy::kNothing;
  }
  const bool held = find_with_prior(input, *expected, mapping);
  if (overrule_motion(input, *expected, held, mapping)) {
    return FoundBy::kFeatures;
  }
  return held && s->motion.departures == 0 ? FoundBy::kPrior : FoundBy::kNothing;
}

/// A frame with a pose.
void accept_pose(MapState* mapping, ModeState* mode, Counters* counters) {
  mapping->pose_valid = true;
  counters->relocalised += mode->now == Mode::kLost ? 1 : 0;
  change_mode(ModeEvent::kPoseFound, mode);
}

/// The map does not grow while a hypothesis selection is out. It grows during an adjustment, and
/// the result is merged.
bool may_grow(const Component::State& s) {
  return (!is_out(s.jobs.map) || is_out_with<AdjustmentJob>(s.jobs.map)) &&
         wants_keyframe(map_input(s), s.mapping);
}

/// Makes this frame a keyframe and requests an adjustment, which waits for the one that is out.
void grow(Component::State* s) {
  PictureState& picture = s->picture;
  MapState& mapping = s->mapping;
  sharpen_outline(&picture.mask_state);
  veto_features(picture.mask_state, &s->features.features, &mapping.localised.matches);
  stage_done(Stage::kMask, s->timer);
  if (!may_grow(*s)) {
    return;
  }
  const Growth growth = grow_map(map_input(*s), &mapping);
  if (growth.keyframe.valid()) {
    mapping.growth = {.any = true, .closed = mapping.growth.closed || growth.loop_found};
    ask_for_adjustment_after_growth(adjustment_view(*s), &mapping, &s->jobs);
  }
}

/// Checks a pose against the motion so far, by which it was not constrained.
/// @return time of the previous pose, where that one proves wrong.
std::optional<std::int64_t> judge(const std::optional<ExpectedPose>& expected,
                                  std::int64_t now_ns,
                                  MapState* mapping,
                                  MotionEstimate* motion,
                                  JobQueue* jobs) {
  const bool repeated = repeats_last({.timestamp_ns = now_ns,
                                      .pose = mapping->localised.absolute.pose,
                                      .covariance = with_clutter(mapping->localised)},
                                     motion);
  if (repeated) {
    mapping->pose_updates_motion = false;
    if (expected) {
      mark_inconsistent(expected->prediction, mapping);
    }
    return std::nullopt;
  }
  if (expected ? jumps_by_drift(*expected, *mapping) : is_revisited(*mapping)) {
    pass_over_pose(motion);
    return std::nullopt;
  }
  const PoseJudgement judgement = check_pose(now_ns,
                                             mapping->localised.absolute.pose,
                                             with_clutter(mapping->localised),
                                             mapping->drift,
                                             motion);
  if (judgement.begun_anew) {
    invalidate_fits(jobs);
  }
  if (expected && motion->departures > 0) {
    mark_inconsistent(expected->prediction, mapping);
  }
  return judgement.withdrawn_ns;
}

/// Removes the keyframe of a wrong pose before the map grows from it.
void withdraw(std::int64_t timestamp_ns, MapState* mapping) {
  withdraw_keyframe(timestamp_ns, &mapping->map);
  keep_matches_of_map(mapping->map, &mapping->localised.matches);
  keep_matches_of_map(mapping->map, &mapping->reference.points);
}

/// A pose constrained by the prior. It does not update the motion, so the prediction's sigma grows
/// until no such pose is accepted. Missed landmarks are not counted as failures. The map grows
/// where the inliers suffice for a pose without the prior.
void keep_hold(Component::State* s) {
  MapState* mapping = &s->mapping;
  mapping->pose_updates_motion = false;
  const int inliers_min = s->configuration.parameters.localise.inliers_min;
  if (s->picture.verdict.decision == FrameDecision::kUse &&
      mapping->localised.absolute.inliers >= inliers_min && may_grow(*s)) {
    grow(s);
    renew_reference(s->clock.frame, mapping);
  }
  accept_pose(mapping, &s->mode, &s->counters);
}

}  // namespace

void lose_target(Component::State* s) {
  drop_reference(&s->mapping);
  s->mapping.localised.matches.clear();
  if (has_target(s->mode)) {
    ++s->counters.lost;
    clear(&s->initialisation);
    invalidate_start(&s->jobs);
  }
  change_mode(ModeEvent::kPoseNotFound, &s->mode);
}

void track(const std::optional<PosePrediction>& predicted, Component::State* s) {
  std::optional<ExpectedPose> expected;
  if (predicted) {
    expected = expected_at(*predicted, s->clock.timestamp_ns, s->motion);
  }
  const FoundBy found_by = find_pose(expected, s);
  if (found_by == FoundBy::kNothing) {
    stage_done(Stage::kMap, s->timer);
    lose_target(s);
    collect(s);
    return;
  }
  if (found_by == FoundBy::kPrior) {
    keep_hold(s);
    return;
  }
  MapState* mapping = &s->mapping;
  const AbsolutePose& found = mapping->localised.absolute;
  const std::optional<std::int64_t> wrong_ns =
      judge(expected, s->clock.timestamp_ns, mapping, &s->motion, &s->jobs);
  const std::optional<PosePrediction> prior = pose_by_joint_model(
      s->motion, s->configuration.parameters.motion, s->clock.timestamp_ns, s->motion.R_IC);
  if (prior) {
    fuse_with_prior(*prior, mapping);
  }
  if (wrong_ns) {
    withdraw(*wrong_ns, mapping);
  }
  if (found_by == FoundBy::kFeatures) {
    mapping->before.inliers = found.inliers;
  }
  const bool may_teach =
      s->picture.verdict.decision == FrameDecision::kUse && mapping->pose_updates_motion;
  if (may_teach) {
    count_observations(s->configuration.camera, found_by == FoundBy::kFlow, mapping);
  }
  bool grows = may_teach && may_grow(*s);
  if (grows && found_by == FoundBy::kFlow) {
    detect_once(s->picture, s->configuration, s->steps_to_shed > 0, s->timer, &s->features);
    grows = match_features(map_input(*s), prior, mapping);
  }
  if (grows) {
    stage_done(Stage::kMap, s->timer);
    grow(s);
    renew_reference(s->clock.frame, mapping);
  } else if (!mapping->reference.valid) {
    renew_reference(s->clock.frame, mapping);
  }
  accept_pose(mapping, &s->mode, &s->counters);
}

}  // namespace polhode
