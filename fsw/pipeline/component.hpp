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

/// Octets that a component needs for its own tables with these parameters.
struct MemoryNeed {
  std::size_t total = 0;
  std::span<const TableNeed> tables;  ///< the total, one by one
};
MemoryNeed memory_needed(const Parameters& parameters);

/// One camera frame. A frame that the camera could not deliver whole (truncated file, transfer
/// error) comes with `readable` false and no image: it is counted and answered, never looked at.
struct Frame {
  std::int64_t timestamp_ns = 0;  ///< mid-exposure, strictly increasing
  ImageView image;                ///< read during the step only
  bool readable = true;
};

/// Work that takes longer than a frame has time: the start of a map, adjustments of it, the fit of
/// the dynamics, the shape, a test of the camera. The step hands it out, the caller runs it
/// where it likes while steps go on, and hands it back to the step that it names, so that the
/// packets do not depend on how long it took.
struct Job;

/// In the order in which they are best run. Out at a time: one of the map, one fit, one shape
/// or test of the camera.
using Jobs = FixedVector<Job*, 3>;

/// Does the work. Touches nothing but the job.
void run_job(Job& job);

/// Instead of run_job, when there is no memory for it: it comes back without a result, which the
/// step counts and does without.
void skip_job(Job& job);

/// Number of the step (the first is 0) that takes the result.
std::uint32_t due_step(const Job& job);

struct StepInput {
  Frame frame;
  /// The observer's attitude at the frame: q_IC, w, x, y, z, C's components to inertial ones.
  /// Without it the last attitude and rate that came by command are carried on; without those the
  /// camera keeps its attitude.
  std::optional<std::array<double, 4>> q_IC = {};
  Jobs finished = {};  ///< the jobs that name this step, run to their end
  /// Libraries have drawn on the reserve since the last step: for a while less is asked of them
  /// (fewer features, a smaller window), and the step is counted.
  bool memory_short = false;
  /// Command packets received since the last step, one each, carried out before the frame is looked
  /// at. At most limits::kStepCommands; those beyond are rejected.
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
  FrameVerdict verdict;  ///< on the picture: what was wrong with it, and by what number
  MotionState motion;
  std::span<const std::uint8_t> packets;  ///< whole packets, in order; valid until the next step
  std::span<const Observation> observations;  ///< valid until the next step
  Jobs jobs;                                  ///< to be run by the caller
  bool checkpoint_asked = false;              ///< by command: the caller is to write one now
};

/// Called at the end of each stage, in the order of the flow, save that a new keyframe comes back
/// from the map to the mask; lets the caller time the stages with its own clock. Must not throw.
using StageHook = void (*)(void* context, Stage stage);

class Component {
 public:
  /// Builds a component inside `memory`, which must outlive it and be aligned to 64 octets.
  /// @errors BadParameter (names field, value, range), MemoryTooSmall.
  static Result<Component*> create(std::span<std::byte> memory, const Parameters& parameters);

  /// Gives back what the component has drawn from the heap by way of libraries; the memory is the
  /// caller's again.
  static void destroy(Component* component);

  /// One frame. Bounded work; the output's spans stay valid until the next call.
  const StepOutput& step(const StepInput& input);

  /// Where a point of the target will be, by what the last step left. Changes nothing; between
  /// steps.
  /// @return empty, or why there is no answer; then `answer` is untouched. @cost up to 2 ms.
  [[nodiscard]] std::string_view predict_point(const PointQuestion& question,
                                               PointState* answer) const;

  void set_stage_hook(StageHook hook, void* context);
  [[nodiscard]] const Counters& counters() const;
  /// Number of the step to come, by which jobs name theirs. It goes on after a restart, and no
  /// command resets it.
  [[nodiscard]] std::uint32_t next_step() const;

  struct State;

 private:
  friend struct ComponentAccess;
  explicit Component(State* state) : state_(state) {}
  State* state_;
};

}  // namespace polhode
