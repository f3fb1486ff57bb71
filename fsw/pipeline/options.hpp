#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct JobOptions {
  // docs/resources.md: a delay of 1 costs little accuracy, 2 doubles the causal error, 4 may lose the target.
  int delay_frames = 0;  ///< frames from a job's issue to the step that takes its result; 0: windows of the map are adjusted within the step
  int delay_of_all_frames = 1;  ///< the same at most of an adjustment of the whole map, where keyframes are as far apart; 0, beside delay_frames = 0: no job leaves its step
};

/// Is there work for a second thread?
[[nodiscard]] constexpr bool has_work_beside(const JobOptions& jobs) { return jobs.delay_frames > 0 || jobs.delay_of_all_frames > 0; }

/// Resources of the machine. They are decided before start and never exceeded. The component itself uses none of them.
/// The pools are chosen with a margin; docs/resources.md has their use.
struct BudgetOptions {
  double frame_ms = 0.0;  ///< time allowed for a step, longer ones are counted; 0: no limit
  // The standard tables (60 MiB), the pools below (120 MiB), images, stacks and the program.
  int total_mb = 320;     ///< of the whole process, in MiB
  int general_mb = 24;    ///< pool for files, tables of the run and what belongs to no other pool
  // Most is taken by the mask against a lit background: 50 MB in a laboratory at 1080p.
  int step_mb = 64;       ///< pool for library calls within a step
  int jobs_mb = 16;       ///< pool for library calls of jobs
  int reserve_mb = 16;    ///< what a full pool draws on
};

}  // namespace polhode
