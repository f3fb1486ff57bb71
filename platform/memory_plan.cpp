#include "memory_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mask/points.hpp"
#include "os/linux/worker.hpp"
#include "pipeline/camera_job.hpp"
#include "solve/bundle_problem.hpp"

namespace polhode::platform {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

// Measured with this distribution's libraries by tests/memory, which fails when one of them takes
// more.
constexpr std::size_t kHypothesesBytes = 3 * kMiB;
// Of the shape's kd-trees, 26 bytes a point, and all other requests of jobs.
constexpr std::size_t kOtherJobsBytes = kMiB / 2;
constexpr std::size_t kPoseBytes = kMiB;
constexpr std::size_t kHeapHeader = 4096;
// The program's code, its shared libraries, their data and the memory of constructors before the
// pools are open: 26 MiB were measured, and 3.6 MiB more with Ceres's libraries.
constexpr std::size_t kProgramBytes = 30 * kMiB;
constexpr std::size_t kMainStackBytes = 2 * kMiB;
// Configuration, files, names and tables of the program: 1.5 MiB were measured.
constexpr std::size_t kGeneralBytes = 2 * kMiB;
// Frames that are in memory at a time: the one that is decoded and the one that is looked at.
constexpr std::size_t kImages = 2;

std::size_t pixels(const Parameters& p) {
  return static_cast<std::size_t>(p.camera.width_px) * static_cast<std::size_t>(p.camera.height_px);
}

/// Of a working pixel: images and pyramids, evidence and labels, and the graph of a cut, 32
/// bytes a node and its edges. 155 were measured in a laboratory at 1080p, 132 beside the Earth.
std::size_t mask_bytes(const Parameters& p) {
  if (!p.mask.separates_background()) {
    return 0;
  }
  constexpr std::size_t kPerPixel = 160;
  const auto decimation =
      static_cast<std::size_t>(decimation_of(p.camera.width_px, p.camera.height_px));
  return kPerPixel * (pixels(p) / (decimation * decimation));
}

std::size_t adjustment_worst_case(const Parameters& p, int keyframes_max) {
  return adjustment_bytes_max(static_cast<std::size_t>(p.map.adjustment_observations_max),
                              static_cast<std::size_t>(keyframes_max));
}

/// Within a step: of a window of the map, with as many keyframes again, twice, that are held.
std::size_t window_worst_case(const Parameters& p) {
  const bool within = has_work_beside(p.jobs) && p.jobs.delay_frames == 0;
  return within
             ? adjustment_worst_case(p, std::min(p.map.keyframes_max, 3 * p.map.window_keyframes))
             : 0;
}

std::vector<CallCost> calls(const Parameters& p, const MachineNeeds& machine) {
  // A pyramid of three levels is 4/3 of the image, with a border; its gradients are two 16-bit
  // images of a level.
  const std::size_t pyramids = 2 * (pixels(p) * 14 / 10) + 5 * pixels(p);
  return {
      {"optical flow: two pyramids and gradients", Pool::kStep, pyramids},
      {"picture, mask and region of interest", Pool::kStep, 3 * pixels(p)},
      {"frame before, and the mask against a background", Pool::kStep, pixels(p) + mask_bytes(p)},
      {"absolute pose: hypotheses of three points", Pool::kStep, kPoseBytes},
      {"the largest job: an adjustment, or hypotheses",
       has_work_beside(p.jobs) ? Pool::kJobs : Pool::kStep,
       job_worst_case(p)},
      {"adjustment of a window of the map", Pool::kStep, window_worst_case(p)},
      {"files and texts of the program", Pool::kGeneral, kGeneralBytes},
      {"packets that wait for their readers", Pool::kGeneral, machine.general_bytes},
      {"decoding of a frame's file", Pool::kGeneral, machine.decoder_bytes}};
}

std::size_t sum_of(const std::vector<CallCost>& calls, Pool pool) {
  std::size_t sum = 0;
  for (const CallCost& call : calls) {
    sum += call.pool == pool ? call.bytes : 0;
  }
  return sum;
}

std::string misfit(const MemoryPlan& plan) {
  for (const Pool pool : {Pool::kGeneral, Pool::kStep, Pool::kJobs}) {
    std::size_t worst = sum_of(plan.calls, pool);
    if (pool == Pool::kJobs && worst > 0) {
      // A job is begun when its pool has this much in one piece. The heap promises the next lower
      // class boundary, a sixteenth less at most, and keeps a header.
      worst += worst / 16 + kHeapHeader;
    }
    const std::size_t held = plan.pools[static_cast<std::size_t>(pool)];
    if (worst > held) {
      return fmt::format("calls may take {} octets of the pool '{}', which holds {} (budget.{}_mb)",
                         worst,
                         pool_name(pool),
                         held,
                         pool_name(pool));
    }
  }
  if (plan.total_bytes > plan.limit_bytes) {
    return fmt::format(
        "all of it is {} octets, budget.total_mb allows {}", plan.total_bytes, plan.limit_bytes);
  }
  return {};
}

}  // namespace

std::size_t job_worst_case(const Parameters& p) {
  // Where no job leaves its step the camera is not tested.
  const std::size_t camera = has_work_beside(p.jobs)
                                 ? adjustment_bytes_max(CameraJob::kObservations, CameraJob::kPoses)
                                 : 0;
  return kOtherJobsBytes +
         std::max({kHypothesesBytes, adjustment_worst_case(p, p.map.keyframes_max), camera});
}

MemoryPlan plan_memory(const Parameters& p, const MachineNeeds& machine) {
  MemoryPlan plan;
  const MemoryNeed need = memory_needed(p);
  for (const TableNeed& table : need.tables) {
    plan.tables.push_back({std::string(table.name), table.octets});
  }
  plan.tables_bytes = need.total;
  plan.calls = calls(p, machine);
  const auto mib = [](int value) { return static_cast<std::size_t>(value) * kMiB; };
  plan.pools = {mib(p.budget.general_mb),
                mib(p.budget.step_mb),
                mib(p.budget.jobs_mb),
                mib(p.budget.reserve_mb)};
  if (!has_work_beside(p.jobs)) {  // jobs are then done within the step, from its pool
    plan.pools[static_cast<std::size_t>(Pool::kStep)] +=
        std::exchange(plan.pools[static_cast<std::size_t>(Pool::kJobs)], std::size_t{0});
  }
  plan.others = {{"pictures", kImages * pixels(p)},
                 {"stack of the steps", kMainStackBytes},
                 {"stack of the jobs", has_work_beside(p.jobs) ? WorkerOptions{}.stack_bytes : 0},
                 {"program and libraries", kProgramBytes}};
  plan.others.insert(plan.others.end(), machine.rows.begin(), machine.rows.end());
  plan.total_bytes = plan.tables_bytes;
  for (const std::size_t pool : plan.pools) {
    plan.total_bytes += pool;
  }
  for (const PlanRow& row : plan.others) {
    plan.total_bytes += row.bytes;
  }
  plan.limit_bytes = mib(p.budget.total_mb);
  plan.problem = misfit(plan);
  return plan;
}

std::string text_of(const MemoryPlan& plan) {
  const auto row = [](const std::string& name, std::size_t bytes) {
    return fmt::format("  {:<52} {:>12}\n", name, bytes);
  };
  std::string text = "own tables, octets\n";
  for (const PlanRow& table : plan.tables) {
    text += row(table.name, table.bytes);
  }
  text += row("all tables", plan.tables_bytes) + "pools for the libraries\n";
  for (std::size_t i = 0; i < kPoolCount; ++i) {
    text += row(pool_name(static_cast<Pool>(i)), plan.pools[i]);
  }
  text += "the most that one call takes, and its pool\n";
  for (const CallCost& call : plan.calls) {
    text += row(fmt::format("{} ({})", call.name, pool_name(call.pool)), call.bytes);
  }
  text += "the rest\n";
  for (const PlanRow& other : plan.others) {
    text += row(other.name, other.bytes);
  }
  text += row("in all", plan.total_bytes) + row("allowed (budget.total_mb)", plan.limit_bytes);
  return text + (plan.problem.empty() ? "It fits.\n" : "It does not fit: " + plan.problem + "\n");
}

}  // namespace polhode::platform
