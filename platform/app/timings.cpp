#include "app/timings.hpp"

#include <algorithm>
#include <cmath>

#include "os/linux/clock.hpp"

namespace polhode::platform {

using Clock = std::chrono::steady_clock;

void Durations::add(Clock::duration duration) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
  samples_us.push_back(static_cast<std::uint32_t>(std::clamp<std::int64_t>(us, 0, UINT32_MAX)));
}

std::uint32_t Durations::percentile_us(double fraction) const {
  if (samples_us.empty()) {
    return 0;
  }
  std::vector<std::uint32_t> sorted = samples_us;
  std::sort(sorted.begin(), sorted.end());
  const auto rank =
      static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

Timings::Timings(std::size_t frames) : stages(kStageCount), stages_cpu(kStageCount) {
  for (Durations* const span : {&read, &step, &step_cpu, &job}) {
    span->samples_us.reserve(frames);
  }
  for (std::vector<Durations>* const spans : {&stages, &stages_cpu}) {
    for (Durations& span : *spans) {
      span.samples_us.reserve(frames);
    }
  }
}

Timings::Moment Timings::now() {
  return {.time = Clock::now(), .cpu = std::chrono::nanoseconds(clock_ns(CLOCK_THREAD_CPUTIME_ID))};
}

void Timings::start_step() {
  step_start_ = now();
  stage_start_ = step_start_;
  in_step_.fill({});
}

void Timings::end_of_stage(Stage stage) {
  const Moment end = now();
  Spent& spent = in_step_[static_cast<std::size_t>(stage)];
  spent.ended = true;
  spent.time += end.time - stage_start_.time;
  spent.cpu += end.cpu - stage_start_.cpu;
  stage_start_ = end;
}

std::int64_t Timings::end_step() {
  const Moment end = now();
  step.add(end.time - step_start_.time);
  step_cpu.add(end.cpu - step_start_.cpu);
  for (std::size_t i = 0; i < kStageCount; ++i) {
    if (in_step_[i].ended) {
      stages[i].add(in_step_[i].time);
      stages_cpu[i].add(in_step_[i].cpu);
    }
  }
  return step.samples_us.back();
}

void Timings::hook(void* context, Stage stage) {
  static_cast<Timings*>(context)->end_of_stage(stage);
}

const char* stage_name(Stage stage) {
  switch (stage) {
    case Stage::kImage:
      return "image";
    case Stage::kMask:
      return "mask";
    case Stage::kFeatures:
      return "features";
    case Stage::kTracks:
      return "tracks";
    case Stage::kMap:
      return "map";
    case Stage::kShape:
      return "shape";
    case Stage::kMotion:
      return "motion";
    case Stage::kBus:
      return "bus";
    case Stage::kJobs:
      return "jobs";
  }
  return "";
}

}  // namespace polhode::platform
