// How long the stages of a step take: by this machine's clock, and in processor time of the thread
// that steps, which other work on the machine hardly disturbs.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/component.hpp"

namespace polhode::platform {

/// Samples of one span, in whole microseconds.
struct Durations {
  std::vector<std::uint32_t> samples_us;

  void add(std::chrono::steady_clock::duration duration);
  [[nodiscard]] std::uint32_t percentile_us(
      double fraction) const;  ///< nearest rank; 0 without samples
};

class Timings {
 public:
  /// @param frames room is made for these at once: the frame loop adds without growing.
  explicit Timings(std::size_t frames);

  void start_step();
  void end_of_stage(Stage stage);
  std::int64_t end_step();  ///< @return microseconds of the step
  void add_read(std::chrono::steady_clock::duration duration) { read.add(duration); }

  /// For Component::set_stage_hook; the context is a Timings.
  static void hook(void* context, Stage stage);

  Durations read;  ///< reading and decoding a frame's file
  Durations step;
  Durations step_cpu;
  Durations job;  ///< on the second core
  std::vector<Durations>
      stages;  ///< a sample for each step that it was in: all that the step spent on it
  std::vector<Durations> stages_cpu;

 private:
  /// Both clocks at one moment.
  struct Moment {
    std::chrono::steady_clock::time_point time;
    std::chrono::nanoseconds cpu{0};  ///< of the calling thread
  };
  static Moment now();

  struct Spent {
    bool ended = false;
    std::chrono::steady_clock::duration time{0};
    std::chrono::nanoseconds cpu{0};
  };

  Moment step_start_;
  Moment stage_start_;
  std::array<Spent, kStageCount> in_step_;
};

const char* stage_name(Stage stage);

}  // namespace polhode::platform
