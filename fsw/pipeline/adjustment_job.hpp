// The long work as plain data: snapshots that pure functions turn into results.
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

}  // namespace polhode
