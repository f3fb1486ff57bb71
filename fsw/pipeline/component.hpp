// The one public header: a camera's frames in, the motion and shape of the target out.
//
// A component lives in memory that the caller hands over, takes one frame per step and answers with
// plain data. It has no clock, thread, file or environment of its own: the same frames, parameters
// and commands give the same packets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "base/fixed_vector.hpp"
#include "base/image_view.hpp"
#include "base/result.hpp"
#include "bus/counters.hpp"
#include "image/frame_use.hpp"
#include "image/verdict.hpp"
#include "motion/motion_state.hpp"
#include "motion/point_state.hpp"
#include "pipeline/parameters.hpp"

namespace polhode {

inline constexpr const char* kVersion = "0.1.0";

/// One of a component's own tables.
struct TableNeed {
  const char* name = "";
  std::size_t octets = 0;
};

/// Bytes that a component needs for its own tables with these parameters.
struct MemoryNeed {
  std::size_t total = 0;
  std::span<const TableNeed> tables;  ///< the total, one by one
};
MemoryNeed memory_needed(const Parameters& parameters);

/// One camera frame. A frame that was not delivered complete (truncated file, transfer error) has
/// `readable` false and no image: it is counted and answered, never processed.
struct Frame {
  std::int64_t timestamp_ns = 0;  ///< mid-exposure, strictly increasing
  ImageView image;                ///< read during the step only
  bool readable = true;
};

/// Work that takes longer than a frame: initialisation and adjustments of a map, the fit of the
/// dynamics, the shape, a test of the camera. The step hands it out, and the caller runs it on any
/// thread while steps go on. The caller returns it with the step given by due_step(), so that the
/// packets do not depend on how long it took.
struct Job;

/// In order of priority. Out at a time: one of the map, one fit, one shape or test of the camera.
using Jobs = FixedVector<Job*, 3>;

/// Does the work. Changes nothing but the job.
void run_job(Job& job);

/// Replaces run_job() when there is no memory for it. The job returns without a result; the step
/// counts that.
void skip_job(Job& job);

/// Number of the step (the first is 0) that takes the result.
std::uint32_t due_step(const Job& job);

struct StepInput {
  Frame frame;
  /// The observer's attitude at the frame: q_IC, w, x, y, z, C's components to inertial ones.
  /// Without it the attitude last commanded is propagated at its rate; without a command the camera
  /// keeps its attitude.
  std::optional<std::array<double, 4>> q_IC = {};
  Jobs finished = {};  ///< the jobs that name this step, run to their end
  /// Libraries have drawn on the reserve since the last step. The step is counted, and for some
  /// steps they get less work (fewer features, a smaller window).
  bool memory_short = false;
  /// Command packets received since the last step, one each, carried out before the frame is used.
  /// At most limits::kStepCommands; those beyond are rejected.
  std::span<const std::span<const std::uint8_t>> commands = {};
};

/// A measured image point of this frame, for overlays and for re-estimation on the ground.
struct Observation {
  std::int32_t landmark =
      -1;  ///< number of the landmark, never used twice in a run; -1: not (yet) a landmark
  float u_px = 0.0F;  ///< distorted pixel
  float v_px = 0.0F;
  /// Undistorted, on the plane z = 1, where it was at the frame's time.
  std::array<double, 2> normalised = {};
  float sigma_px = 0.0F;
  float predicted_u_px =
      0.0F;  ///< where the landmark reprojects with the frame's pose; meaningful with `landmark`
  float predicted_v_px = 0.0F;
  bool inlier = false;
};

/// Stages of a step, for time measurements by the caller's clock.
enum class Stage : std::uint8_t {
  kImage,
  kMask,
  kFeatures,
  kTracks,
  kMap,
  kShape,
  kMotion,
  kBus,
  kJobs
};
inline constexpr std::size_t kStageCount =
    static_cast<std::size_t>(Stage::kJobs) + 1;  ///< the last one

struct StepOutput {
  FrameUse use = FrameUse::kUsed;
  FrameVerdict verdict;  ///< on the image: its fault, and the number that shows it
  MotionState motion;
  std::span<const std::uint8_t> packets;  ///< whole packets, in order; valid until the next step
  std::span<const Observation> observations;  ///< valid until the next step
  Jobs jobs;                                  ///< to be run by the caller
  bool checkpoint_asked = false;              ///< by command: the caller is to write one now
};

/// Called at the end of each stage, so that the caller can time the stages by its own clock. In the
/// order of the flow, except that a new keyframe runs the mask again after the map. Must not throw.
using StageHook = void (*)(void* context, Stage stage);

class Component {
 public:
  /// Builds a component inside `memory`, which must outlive it and be aligned to 64 bytes.
  /// @errors BadParameter (names field, value, range), MemoryTooSmall.
  static Result<Component*> create(std::span<std::byte> memory, const Parameters& parameters);

  /// Frees heap memory that the component allocated through libraries; `memory` is the caller's
  /// again.
  static void destroy(Component* component);

  /// One frame. Bounded work; the output's spans stay valid until the next call.
  const StepOutput& step(const StepInput& input);

  /// Predicts a point of the target from the state after the last step. Changes nothing. For calls
  /// between steps.
  /// @return empty, or the reason why there is no answer; then `answer` is untouched.
  /// @cost up to 2 ms.
  [[nodiscard]] std::string_view predict_point(const PointQuestion& question,
                                               PointState* answer) const;

  void set_stage_hook(StageHook hook, void* context);
  [[nodiscard]] const Counters& counters() const;
  /// Number of the next step; due_step() counts alike. It continues after a restart, and no command
  /// resets it.
  [[nodiscard]] std::uint32_t next_step() const;

  struct State;

 private:
  friend struct ComponentAccess;
  explicit Component(State* state) : state_(state) {}
  State* state_;
};

}  // namespace polhode
