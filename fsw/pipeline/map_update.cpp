#include "pipeline/map_update.hpp"

#include <algorithm>

#include "geometry/so3.hpp"
#include "map/grow.hpp"
#include "map/update.hpp"
#include "map/validity.hpp"
#include "motion/disturbance.hpp"
#include "pipeline/adjustment.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

/// Takes a motion that was fitted together with the map. The map's drift is then the model's error
/// alone.
void take_motion_of_map(const RigidModel& model,
                        MapState* mapping,
                        MotionEstimate* motion,
                        JobQueue* jobs) {
  const std::optional<DriftByModel> left = take_joint_fit(model, motion);
  jobs->fit.unwanted = true;
  MapDrift& drift = mapping->drift;
  if (left) {
    replace_random_walk(left->covariance_C, &drift);
    constrain_turn(left->relative_speed_sigma, mapping->map.radius_mu, &drift);
  }
  if (reaches_over_reanchoring(*mapping)) {
    close_reanchoring(
        &drift);  // a joint fit of several parts of a map requires observations shared by them
  }
}

/// The map takes the result, and the motion takes the model if there is one. A loop stays open when
/// its adjustment failed.
MapCorrection take_over(MapState* mapping,
                        MotionEstimate* motion,
                        JobQueue* jobs,
                        Counters* counters) {
  const AdjustmentJob& job = jobs->adjustment;
  // A disturbance may have ended the fitted motion while the job was out.
  const bool bound = job.as_free_body && job.model.accepted();
  const bool ended = bound && (job.model_unwanted || motion->departures > 0);
  const bool usable = job.usable && !ended && is_valid(job.snapshot);
  if (ended) {  // the whole map is adjusted again, with free poses
    mapping->growth.any = true;
    mapping->last_adjustment_of_all = {};
    ++counters->jobs_without_result;
  }
  const MapUpdate update = take_adjusted(job.snapshot, usable, job.closed, mapping);
  if (job.closed && !update.applied) {
    mapping->growth.closed = true;
  }
  if (update.applied && job.as_free_body && !job.model_unwanted) {
    if (bound) {
      take_motion_of_map(transformed(job.model, update.correction.back), mapping, motion, jobs);
    } else if (job.model.status == ModelStatus::kResidualsTooLarge && motion->model.of_map) {
      refute_model(motion);
    }
  }
  return update.correction;
}

/// Applies the correction to poses measured after the adjusted keyframes.
void move_since(const MapCorrection& correction, MapState* mapping, MotionEstimate* motion) {
  correct_reference(correction, mapping);
  move_seen(correction.moved(motion->last_seen.pose_C.pose), motion);
  if (move_poses_with_map(mapping->map, correction.timestamp_ns, motion)) {
    mapping->moved_rad = rotation_angle_rad(correction.before.R_CT, correction.after.R_CT);
  }
}

/// Applies it to the newest keyframe's pose, too.
void move_with_newest(const AdjustmentJob& job,
                      std::uint32_t frame,
                      MapState* mapping,
                      MotionEstimate* motion) {
  const Keyframe& keyframe = mapping->map.keyframes[job.keyframe.index()];
  if (!keyframe.used || keyframe.number != job.keyframe_number) {
    return;
  }
  if (!follow_keyframe(keyframe, frame, mapping)) {
    move_pose(keyframe, motion);
  }
}

/// Solves the poses so far again, in a map that was adjusted for the first time.
/// @param input  this frame
void restate(const MapInput& input, MapState* mapping, MotionEstimate* motion, JobQueue* jobs) {
  FixedVector<PoseSample, limits::kKeyframes> poses;
  auto order = keyframes_by_age(mapping->map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    const Keyframe& keyframe = mapping->map.keyframes[id.index()];
    if (!keyframe.used || keyframe.number < jobs->adjustment.first_keyframe) {
      continue;
    }
    const bool solved = pose_from_keyframe(keyframe, input, mapping);
    const AbsolutePose& absolute = mapping->localised.absolute;
    if (keyframe.frame != input.frame && solved) {
      (void)poses.push_back(turned(keyframe.R_IC,
                                   PoseSample{.timestamp_ns = keyframe.timestamp_ns,
                                              .pose = absolute.pose,
                                              .covariance = absolute.covariance}));
    }
    mapping->pose_valid = keyframe.frame == input.frame && solved;
  }
  if (!mapping->pose_valid) {
    mapping->localised.matches.clear();  // they are of an earlier frame
  }
  restate_poses(poses.view(), motion);
  invalidate_fits(jobs);
}

/// Copies the adjusted map for a test of the camera, each time the number of keyframes has doubled.
/// The test is not urgent and never runs within a step.
void prepare_test(const Configuration& configuration,
                  bool memory_short,
                  CameraState* camera,
                  JobQueue* jobs) {
  constexpr std::uint32_t kKeyframesMin = 6;  // fewer hold a map of any depth
  AdjustmentJob& job = jobs->adjustment;
  const std::uint32_t next = job.snapshot.next_keyframe_number;
  const bool due = next >= std::max(kKeyframesMin, 2 * camera->next_keyframe);
  if (due && job.of_all && job.usable && !is_out_with<CameraJob>(jobs->shape) && !memory_short &&
      has_work_beside(configuration.parameters.jobs) && is_valid(job.snapshot)) {
    const MapMotions motions = motions_of(job.snapshot);
    prepare_camera_test(camera_problem_of(motions, configuration.camera, &job.snapshot),
                        &jobs->camera);
    camera->next_keyframe = next;
    camera->waits = true;
  }
}

}  // namespace

AdjustmentView adjustment_view(const Component::State& s) {
  const Parameters& parameters = s.configuration.parameters;
  return {.motion = &s.motion,
          .parameters = &parameters,
          .camera = &s.configuration.camera,
          .short_of_memory = s.steps_to_shed > 0,
          .now_ns = s.clock.timestamp_ns,
          .times = job_times(s)};
}

void take_adjustment(Component::State* s) {
  const AdjustmentJob& job = s->jobs.adjustment;
  const CameraModel& camera = s->configuration.camera;
  const MapCorrection correction = take_over(&s->mapping, &s->motion, &s->jobs, &s->counters);
  move_since(correction, &s->mapping, &s->motion);
  prepare_test(s->configuration, s->steps_to_shed > 0, &s->camera, &s->jobs);
  if (!s->mapping.growth.closed) {
    // Culling would remove the associations of an open loop: its ends are sigmas apart.
    cull_misfits(camera, &s->mapping);
  }
  refresh_map(camera, &s->mapping);
  switch (job.reason) {
    case AdjustmentReason::kMapBegun:
      complete_map(job.first_keyframe, map_input(*s), &s->mapping);
      ask_for_adjustment_of_all(
          AdjustmentReason::kMapCompleted, adjustment_view(*s), &s->mapping, &s->jobs);
      break;
    case AdjustmentReason::kMapCompleted:
      restate(map_input(*s), &s->mapping, &s->motion, &s->jobs);
      break;
    case AdjustmentReason::kMapGrown:
      move_with_newest(job, s->clock.frame, &s->mapping, &s->motion);
      break;
  }
  ask_for_adjustment_after_growth(adjustment_view(*s), &s->mapping, &s->jobs);
}

void adjust_all(int iterations_max, Component::State* s) {
  AdjustmentJob& job = s->jobs.adjustment;
  prepare_adjustment_of_all(adjustment_view(*s), &s->mapping, &s->jobs.adjustment);
  set_rounds(iterations_max, s->configuration.parameters.map, &job);
  run_adjustment(&job);
  (void)take_over(&s->mapping, &s->motion, &s->jobs, &s->counters);
}

}  // namespace polhode
