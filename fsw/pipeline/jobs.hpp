// The long work, apart from the step: plain snapshots that a pure function turns into results, on
// whichever thread the caller likes.
//
// One job of the map, one fit of the dynamics and one estimate of the shape are out at a time; none
// waits for another, as the last two change nothing of the map. A result is taken in at a step that
// is named when the job is issued (logical execution time), so the packets do not depend on how
// long the work took.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/fixed_vector.hpp"
#include "base/ids.hpp"
#include "config/limits.hpp"
#include "initialisation/start_job.hpp"
#include "map/window.hpp"
#include "motion/joint_fit.hpp"
#include "motion/rigid_model.hpp"
#include "pipeline/component.hpp"
#include "shape/shape.hpp"

namespace polhode {

enum class JobKind : std::uint8_t { kNone, kStart, kAdjustment, kFit, kShape };

/// What all jobs have in common.
struct Job {
  JobKind kind = JobKind::kNone;  ///< kNone: it is not out
  bool done = false;
  bool skipped = false;   ///< there is no result
  bool unwanted = false;  ///< the result is for nothing: what it was taken from has been given up
  std::uint32_t issued_step = 0;
  std::uint32_t due_step = 0;
};

/// What an adjustment is for, which decides what follows from it.
enum class AdjustmentReason : std::uint8_t { kMapBegun, kMapCompleted, kMapGrown };

/// How large the map was when all of it was adjusted last.
struct LastAdjustment {
  std::uint32_t keyframes = 0;
  std::uint32_t next_keyframe_number = 0;
};

/// A joint adjustment of part of the map, in rounds with a loss of their own; then, where asked
/// for, of all of it as a free body's, which stands where the images bear it out.
struct AdjustmentJob {
  static constexpr std::size_t kRounds = 3;
  AdjustmentReason reason = AdjustmentReason::kMapGrown;
  bool closed = false;  ///< a loop
  KeyframeId keyframe;  ///< newest one that the map has grown by
  std::uint32_t keyframe_number = 0;
  std::uint32_t first_keyframe = 0;  ///< number of the first one of the part that has begun
  FixedVector<BundleOptions, kRounds> rounds;
  AdjustmentSnapshot snapshot;  ///< in: as the map is; out: as it should be
  BundleWorkspace workspace;
  bool usable = false;  ///< of the result

  bool as_free_body = false;
  bool model_unwanted = false;  ///< the motion so far has been given up since
  double body_radius_mu = 1.0;
  MotionOptions motion;
  RigidModel model;          ///< in: the last one; out: of this map, where accepted
  std::uint32_t doubts = 0;  ///< carried from one fit to the next
  JointFitWorkspace joint;
};

/// By what the map has grown while an adjustment of it was out; the next one is for that.
struct GrowthWaiting {
  bool any = false;
  bool closed = false;  ///< a loop, too
};

/// Work on the map, of one kind or the other.
struct MapJob : Job {
  StartJob start;
  AdjustmentJob adjustment;
};

/// A fit of the dynamics to the poses so far.
struct FitJob : Job {
  MotionSnapshot snapshot;
  MotionWorkspace workspace;
  std::uint32_t poses_new = 0;  ///< since the fit before
  RigidModel model;             ///< the result
};

/// An estimate of the shape, in map units.
struct ShapeJob : Job {
  FixedVector<Eigen::Vector3d, limits::kLandmarks> landmarks_T;
  ShapeOptions options;
  std::uint64_t seed = 0;
  std::optional<Shape> previous;
  ShapeWork work;
  std::optional<Shape> outcome;  ///< the result
};

/// Sends off what has been prepared in `state->job`: to the caller with this step's output, or,
/// with a delay of 0, to run_undelayed_jobs.
void issue_job(JobKind kind, Component::State* state);

/// As issue_job, of `state->fit_job`; with a delay of 0 the fit is run and taken in here.
void issue_fit(Component::State* state);

/// As issue_fit, of `state->shape_job`.
void issue_shape(Component::State* state);

/// No job of the map is out: a new one may be prepared.
[[nodiscard]] bool job_slot_free(const Component::State& state);
[[nodiscard]] bool fit_slot_free(const Component::State& state);
[[nodiscard]] bool shape_slot_free(const Component::State& state);

/// Takes the results in whose step has come; may issue the next jobs.
void take_due_jobs(const Jobs& finished, Component::State* state);

/// A contest that is out is for frames that are no longer there.
void give_up_start(Component::State* state);

/// What is out belongs to a target that is forgotten.
void forget_jobs(Component::State* state);

/// With a delay of 0 frames: runs the map's job here, and those that follow from it.
void run_undelayed_jobs(Component::State* state);

/// At the end of a run: what is still out is run, unless that is done, and taken in.
void close_jobs(Component::State* state);

/// The jobs that this step has issued for the caller to run.
[[nodiscard]] Jobs jobs_for_caller(Component::State* state);

}  // namespace polhode
