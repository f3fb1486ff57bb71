#include "app/live_run.hpp"

#include <algorithm>
#include <optional>

#include "app/checkpoint_writer.hpp"
#include "app/crash_mark.hpp"
#include "app/exposure_control.hpp"
#include "app/next_input.hpp"
#include "os/linux/clock.hpp"
#include "os/linux/memory/region.hpp"
#include "os/linux/stop_request.hpp"

namespace polhode::platform {
namespace {

// How soon a request to stop is seen when no frame comes.
constexpr int kWait_ms = 100;

void record_passed_over(LiveParts& parts, std::uint32_t late_before) {
  const std::uint32_t late = parts.camera.counters().frames_late - late_before;
  if (parts.recorder != nullptr && late > 0) {
    parts.recorder->dropped(DropReason::kLate, late);
  }
}

WriteFailures write_failures(const LiveParts& parts) {
  return {.packets = parts.packets != nullptr ? parts.packets->failures() : 0,
          .checkpoints = parts.checkpoint != nullptr ? parts.checkpoint->counters().failed : 0,
          .records = parts.recorder != nullptr ? parts.recorder->counters().write_failures : 0,
          .streamed = parts.transports.refused_by_disk()};
}

/// Reports failed writes at once: on stderr, and on the bus.
void notify_disk(LiveParts& parts, std::int64_t now_ns) {
  const WriteFailures failures = write_failures(parts);
  if (parts.report.written(failures, now_ns)) {
    parts.telemetry.disk_refused(failures, parts.transports, parts.report.last().timestamp_ns);
  }
}

const StepOutput& step_from_pool(Component& component, const StepInput& input) {
  const PoolScope scope(Pool::kStep);
  return component.step(input);
}

/// The frame that finds the work for it unfinished is dropped; the next one is tried. Frames that
/// wait, of a sequence as fast as the steps, wait for the work, too.
bool dropped_for_job(LiveParts& parts) {
  if (parts.camera.frames_wait() || !parts.worker.late_for(parts.component.next_step())) {
    return false;
  }
  ++parts.counts.frames_dropped_for_job;
  if (parts.recorder != nullptr) {
    parts.recorder->dropped(DropReason::kJob, 1);
  }
  return true;
}

/// One accepted frame, from the step to everything that follows from it.
/// @param cpu_before_ns this thread's processor time before the frame was requested.
/// @return processor time of the step.
std::int64_t take_frame(LiveParts& parts,
                        const Frame& frame,
                        std::int64_t cpu_before_ns,
                        const LiveLimits& limits) {
  LiveCounts& counts = parts.counts;
  const auto commands = parts.transports.received();
  if (parts.recorder != nullptr) {
    for (const std::span<const std::uint8_t> command : commands) {
      parts.recorder->command(command);
    }
    parts.recorder->frame(frame);
  }
  const std::int64_t before_ns = clock_ns(CLOCK_MONOTONIC);
  StepInput input = next_input(parts.component, parts.worker, frame);
  input.commands = commands;
  const std::int64_t step_cpu_before_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
  const StepOutput& out = step_from_pool(parts.component, input);
  const std::int64_t step_cpu_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID) - step_cpu_before_ns;
  const std::int64_t stepped_ns = clock_ns(CLOCK_MONOTONIC);
  parts.worker.submit(out.jobs);
  parts.transports.send(out.packets);
  if (parts.packets != nullptr) {
    (void)parts.packets->append(out.packets);
  }
  const std::int64_t published_ns = clock_ns(CLOCK_MONOTONIC);
  counts.step.add(stepped_ns - before_ns);
  counts.publish.add(published_ns - stepped_ns);
  counts.last_step_us = (stepped_ns - before_ns) / 1000;
  counts.last_step = moment_now();
  (void)counts.deadline.add(counts.last_step_us);
  counts.latency.add(published_ns - parts.camera.available_ns());
  counts.latency_cpu.add(clock_ns(CLOCK_THREAD_CPUTIME_ID) - cpu_before_ns);
  if (is_measured(out.motion)) {
    ++counts.frames_with_pose;
    counts.first_pose_frame = std::min(counts.first_pose_frame, counts.frames_accepted);
  }
  ++counts.frames_accepted;
  if (parts.crash != nullptr) {
    parts.crash->stepped();
  }
  const auto every = static_cast<std::uint32_t>(limits.checkpoint_frames);
  const bool due = counts.frames_accepted % every == 0 || out.checkpoint_asked;
  if (parts.checkpoint != nullptr && due) {
    parts.checkpoint->offer(parts.component, counts.last_step);
  }
  parts.exposure.after(out, view_of(parts.component), parts.camera);
  parts.report.stepped(out);
  return step_cpu_ns;
}

}  // namespace

LiveEnd run_live(LiveParts& parts, const LiveLimits& limits) {
  const std::int64_t start_ns = clock_ns(CLOCK_MONOTONIC);
  std::uint32_t attempts = 0;
  std::uint32_t late = 0;
  Frame frame;
  while (!stop_requested()) {
    const std::int64_t cpu_before_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    const Arrival arrival = parts.camera.next(kWait_ms, &frame);
    const CameraCounters& camera = parts.camera.counters();
    std::optional<std::int64_t> step_cpu_ns;
    const std::int64_t now_ns = clock_ns(CLOCK_MONOTONIC);
    if (arrival == Arrival::kEnded) {
      return LiveEnd::kPlayed;
    }
    record_passed_over(parts, late);
    late = camera.frames_late;
    if (arrival == Arrival::kFrame && !dropped_for_job(parts)) {
      step_cpu_ns = take_frame(parts, frame, cpu_before_ns, limits);
    } else if (arrival != Arrival::kFrame && limits.start_s_max > 0 && camera.opened == 0 &&
               now_ns - start_ns > std::int64_t{limits.start_s_max} * 1'000'000'000) {
      return LiveEnd::kNoCamera;
    }
    // Progress is a frame that was stepped or, without a camera, another attempt at it: waiting is
    // none, so a stream that hangs in the kernel is noticed, nor is a frame dropped for a job, so
    // one that hangs is.
    if (step_cpu_ns || camera.attempts != attempts) {
      parts.manager.progress(now_ns);
    }
    attempts = camera.attempts;
    notify_disk(parts, now_ns);
    parts.report.passed(parts.camera, parts.counts, now_ns);
    parts.telemetry.passed(
        parts.counts, parts.camera, parts.transports, now_ns, parts.report.last().timestamp_ns);
    if (step_cpu_ns) {
      parts.counts.outside_cpu.add(clock_ns(CLOCK_THREAD_CPUTIME_ID) - cpu_before_ns -
                                   *step_cpu_ns);
    }
    if (limits.frames_max > 0 &&
        parts.counts.frames_accepted >= static_cast<std::uint32_t>(limits.frames_max)) {
      return LiveEnd::kPlayed;
    }
  }
  return LiveEnd::kStopped;
}

}  // namespace polhode::platform
