#include "pipeline/motion_jobs.hpp"

#include "geometry/so3.hpp"
#include "motion/residual_level.hpp"
#include "pipeline/jobs.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

std::optional<Eigen::Quaterniond> reported_attitude(const StepInput& input,
                                                    const ServicerAttitude& servicer) {
  if (input.q_IC) {
    const std::array<double, 4>& q = *input.q_IC;
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  if (!servicer.known) {
    return std::nullopt;
  }
  const double since_s =
      1e-9 * static_cast<double>(input.frame.timestamp_ns - servicer.timestamp_ns);
  return servicer.q_IC * Eigen::Quaterniond(so3_exp(since_s * servicer.w_C_rad_s));
}

void give_up_fits(Component::State* s) {
  s->fit_job.unwanted = true;
  s->job.adjustment.model_unwanted = true;
}

void ask_for_fit(Component::State* s) {
  FitJob& job = s->fit_job;
  prepare_fit(s->map, s->drift, s->parameters.motion, &s->motion, &job.snapshot);
  job.poses_new = s->motion.poses_since_fit;
  issue_fit(s);
}

}  // namespace

void set_observer(const StepInput& input, Component::State* s) {
  const std::optional<Eigen::Matrix3d> turn =
      take_observer(reported_attitude(input, s->bus.servicer), &s->motion);
  if (!turn) {
    return;
  }
  for (Keyframe& keyframe : s->map.keyframes) {
    keyframe.R_IC = *turn * keyframe.R_IC;
  }
  for (CollectedFrame& frame : s->initialisation.tracks.frames) {
    frame.R_IC = *turn * frame.R_IC;
  }
  give_up_fits(s);
}

void remember_motion(std::int64_t timestamp_ns,
                     const Pose& pose,
                     const PoseCovariance& covariance,
                     Component::State* s) {
  const bool fit_is_due =
      remember_pose(timestamp_ns, pose, covariance, s->parameters.motion, &s->motion);
  if (fit_is_due && fit_slot_free(*s)) {
    ask_for_fit(s);
  }
}

void restate_motion(std::span<const PoseSample> start, Component::State* s) {
  restate_poses(start, &s->motion);
  give_up_fits(s);
}

void take_fit_job(Component::State* s) {
  const FitJob& job = s->fit_job;
  if (!job.skipped) {
    take_fit(
        job.model, job.snapshot.poses.back().timestamp_ns, job.poses_new, s->drift, &s->motion);
  }
}

void take_map_motion(const RigidModel& model, Component::State* s) {
  const std::optional<DriftByModel> left = take_joint_fit(model, &s->motion);
  s->fit_job.unwanted = true;
  if (left) {
    replace_walk(left->covariance_C, &s->drift);
    hold_turn(left->relative_speed_sigma, s->map.radius_mu, &s->drift);
  }
}

void drop_model(Component::State* s) {
  s->motion.model = {};
  give_up_fits(s);
}

void forget_motion(Component::State* s) {
  forget_poses(&s->motion);
  give_up_fits(s);
  s->ahead.walk.under_way = false;
}

}  // namespace polhode
