#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct JobOptions {
  int delay_frames = 0;  ///< frames from a job's issue to the step that takes its result; 0: within the step, 0 .. 60
};

/// What the machine gives; decided before start and never exceeded. The component itself needs none of it.
struct BudgetOptions {
  double frame_ms = 0.0;  ///< time that a step may take; 0: none is set, 0 .. 10000
  int total_mb = 320;     ///< of the whole process, in MiB, 32 .. 16384
  int general_mb = 24;    ///< pool for files, tables of the run and whatever is not one of the others, 2 .. 4096
  int step_mb = 64;       ///< pool for the libraries called within a step, 4 .. 4096
  int jobs_mb = 8;        ///< pool for those called by jobs, 4 .. 4096
  int reserve_mb = 16;    ///< for what overflows from the pools, 1 .. 4096
};

}  // namespace polhode
