#include "memory_plan.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <vector>

#include "app/machine_needs.hpp"
#include "os/linux/deadline.hpp"
#include "os/linux/memory/heap.hpp"
#include "os/linux/worker.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::platform::plan_test {
namespace {

Parameters at(int width_px, int height_px) {
  Parameters p;
  p.camera = {.width_px = width_px,
              .height_px = height_px,
              .fu_px = 1000.0,
              .fv_px = 1000.0,
              .cu_px = 320.0,
              .cv_px = 240.0};
  return p;
}

TEST(MemoryPlan, OfTheDefaultsFits) {
  EXPECT_EQ(plan_memory(at(640, 480)).problem, "");
  EXPECT_EQ(plan_memory(at(1920, 1080)).problem, "");
}

/// Of the mask against a background, in the plan: its call without the frame before.
std::size_t mask_bytes_of(const Parameters& p) {
  for (const CallCost& call : plan_memory(p).calls) {
    if (call.name.find("mask against a background") != std::string::npos) {
      return call.bytes - static_cast<std::size_t>(p.camera.width_px * p.camera.height_px);
    }
  }
  return 0;
}

TEST(MemoryPlan, TakesTheMaskAtThePixelsThatItWorksOn) {
  constexpr std::size_t kPerPixel = 160;
  EXPECT_EQ(mask_bytes_of(at(640, 480)), kPerPixel * 640 * 480);
  EXPECT_EQ(mask_bytes_of(at(1280, 720)), kPerPixel * 640 * 360);
  // Three would do to be at most 640 across, but images are halved: four.
  EXPECT_EQ(mask_bytes_of(at(1920, 1080)), kPerPixel * 480 * 270);
  EXPECT_EQ(mask_bytes_of(at(3840, 2160)), kPerPixel * 480 * 270);
}

TEST(MemoryPlan, ListsTheTablesWhole) {
  const Parameters p = at(640, 480);
  const MemoryPlan plan = plan_memory(p);
  std::size_t sum = 0;
  for (const PlanRow& table : plan.tables) {
    EXPECT_GT(table.bytes, 0U) << table.name;
    sum += table.bytes;
  }
  EXPECT_EQ(sum, memory_needed(p).total);
  EXPECT_EQ(plan.tables_bytes, sum);
}

TEST(MemoryPlan, TheTotalIsTheSumOfItsParts) {
  const MemoryPlan plan = plan_memory(at(1280, 720));
  std::size_t sum = std::accumulate(plan.pools.begin(), plan.pools.end(), plan.tables_bytes);
  for (const PlanRow& row : plan.others) {
    sum += row.bytes;
  }
  EXPECT_EQ(plan.total_bytes, sum);
}

TEST(MemoryPlan, RefusesATotalThatIsTooSmall_AndReportsTheNeed) {
  Parameters p = at(640, 480);
  p.budget.total_mb = 64;
  const MemoryPlan plan = plan_memory(p);
  EXPECT_NE(plan.problem.find("budget.total_mb"), std::string::npos);
  EXPECT_NE(plan.problem.find(std::to_string(plan.total_bytes)), std::string::npos);
  EXPECT_NE(text_of(plan).find("does not fit"), std::string::npos);
}

TEST(MemoryPlan, OfAnUprightImageIsThatOfALyingOne) {
  for (const auto& [longer, shorter] : {std::pair(960, 540), std::pair(1920, 1080)}) {
    const MemoryPlan upright = plan_memory(at(shorter, longer));
    EXPECT_EQ(upright.problem, "");
    EXPECT_EQ(upright.total_bytes, plan_memory(at(longer, shorter)).total_bytes);
  }
}

TEST(MemoryPlan, RefusesAPoolThatTheWorstCallsOverflow) {
  Parameters p = at(1920, 1080);
  p.budget.step_mb = 8;
  EXPECT_NE(plan_memory(p).problem.find("budget.step_mb"), std::string::npos);
  p = at(640, 480);
  p.jobs.delay_frames = 1;
  p.budget.jobs_mb = 14;
  EXPECT_EQ(plan_memory(p).problem, "");
  p.budget.jobs_mb = 13;
  EXPECT_NE(plan_memory(p).problem.find("budget.jobs_mb"), std::string::npos);
  p.map.adjustment_observations_max = 9000;
  EXPECT_EQ(plan_memory(p).problem, "");
}

TEST(MemoryPlan, WithoutDelayTheJobsDrawFromTheStepsPool) {
  Parameters p = at(640, 480);
  p.jobs = {.delay_frames = 0, .delay_of_all_frames = 0};
  const MemoryPlan within = plan_memory(p);
  p.jobs.delay_frames = 2;
  const MemoryPlan beside = plan_memory(p);
  EXPECT_EQ(within.pools[static_cast<std::size_t>(Pool::kJobs)], 0U);
  EXPECT_GT(beside.pools[static_cast<std::size_t>(Pool::kJobs)], 0U);
  EXPECT_EQ(within.total_bytes + WorkerOptions{}.stack_bytes, beside.total_bytes)
      << "no thread, no stack";
}

TEST(MemoryPlan, AWindowThatIsAdjustedWithinTheStepIsInTheStepsPool) {
  Parameters p = at(640, 480);
  const MemoryPlan within = plan_memory(p);
  p.jobs.delay_frames = 1;
  const MemoryPlan beside = plan_memory(p);
  const auto bytes = [](const MemoryPlan& plan) {
    for (const CallCost& call : plan.calls) {
      if (call.name == "adjustment of a window of the map") {
        EXPECT_EQ(call.pool, Pool::kStep);
        return call.bytes;
      }
    }
    return std::size_t{0};
  };
  EXPECT_GT(bytes(within), 8'000'000U) << "of 10000 observations";
  EXPECT_EQ(bytes(beside), 0U);
  EXPECT_EQ(within.pools, beside.pools);
}

TEST(MemoryPlan, AJobsPoolThatIsAllowedLetsAJobBegin) {
  Parameters p = at(640, 480);
  p.jobs.delay_frames = 1;
  p.budget.jobs_mb = 14;
  const MemoryPlan plan = plan_memory(p);
  ASSERT_EQ(plan.problem, "");
  std::vector<std::byte> memory(plan.pools[static_cast<std::size_t>(Pool::kJobs)] + 64);
  void* start = memory.data();
  std::size_t space = memory.size();
  Heap heap;
  heap.open({static_cast<std::byte*>(std::align(64, memory.size() - 64, start, space)),
             memory.size() - 64});
  EXPECT_GE(heap.use().largest_free_bytes, job_worst_case(p));
}

TEST(MemoryPlan, HoldsWhatALiveRunNeedsBesideTheEstimator) {
  MachineOptions machine;
  machine.device.source = "/dev/video0";
  const Parameters p = at(640, 480);
  const std::size_t bare = plan_memory(p, live_needs(machine, {}, p.camera)).total_bytes;
  EXPECT_EQ(bare, plan_memory(p).total_bytes + 4 * 3 * 640 * 480);
  machine.device.pixel_format = "GREY";
  EXPECT_EQ(plan_memory(p, live_needs(machine, {}, p.camera)).total_bytes,
            plan_memory(p).total_bytes + 4 * 640 * 480);
  machine.device.pixel_format = "auto";
  machine.run.checkpoint = "checkpoint";
  const std::size_t kept = plan_memory(p, live_needs(machine, {}, p.camera)).total_bytes;
  EXPECT_EQ(kept, bare + checkpoint_octets_max());
  machine.recording.folder = "recordings";
  const std::size_t recorded = plan_memory(p, live_needs(machine, {}, p.camera)).total_bytes;
  EXPECT_GT(recorded, kept + 10 * 2 * 640 * 480);
}

TEST(MemoryPlan, RefusesMoreReadersThanTheGeneralPoolHasRoomFor) {
  Parameters p = at(640, 480);
  p.budget.general_mb = 4;
  TransportOptions options;
  options.transport.send = {"unix:/tmp/a", "udp:10015"};
  EXPECT_EQ(plan_memory(p, transport_needs(options, p.camera)).problem, "");
  options.transport.send.insert(options.transport.send.end(), 2, "udp:10016");
  EXPECT_NE(plan_memory(p, transport_needs(options, p.camera)).problem.find("budget.general_mb"),
            std::string::npos);
}

TEST(MemoryPlan, HoldsTheFilesOfASequence_AndWhatDecodingTakes) {
  const Parameters p = at(640, 480);
  Sequence sequence{
      .path = {}, .image_folder = {}, .camera = p.camera, .frames = {}, .warnings = {}};
  sequence.file_bytes_max = 900'000;
  MachineNeeds needs;
  add_sequence(sequence, &needs);
  EXPECT_EQ(plan_memory(p, needs).total_bytes, plan_memory(p).total_bytes + 900'000);
  EXPECT_EQ(plan_memory(p, needs).problem, "");
  sequence.decoder_bytes = std::size_t{30} << 20U;
  add_sequence(sequence, &needs);
  EXPECT_NE(plan_memory(p, needs).problem.find("budget.general_mb"), std::string::npos);
}

TEST(MemoryPlan, ALargerImageTakesMore) {
  EXPECT_GT(plan_memory(at(1920, 1080)).total_bytes, plan_memory(at(640, 480)).total_bytes);
}

// verifies: RES-05
TEST(DeadlineMonitor, CountsWhatWasLate) {
  DeadlineMonitor monitor(10.0);
  EXPECT_TRUE(monitor.add(10'000));
  EXPECT_FALSE(monitor.add(10'001));
  EXPECT_FALSE(monitor.add(50'000));
  EXPECT_TRUE(monitor.add(9'000));
  EXPECT_FALSE(monitor.add(11'000));
  EXPECT_EQ(monitor.missed(), 3U);
  EXPECT_EQ(monitor.missed_in_a_row_max(), 2U);
  EXPECT_EQ(monitor.worst_us(), 50'000);
}

TEST(DeadlineMonitor, WithoutADeadlineNothingIsLate) {
  DeadlineMonitor monitor(0.0);
  EXPECT_TRUE(monitor.add(1'000'000));
  EXPECT_EQ(monitor.missed(), 0U);
}

}  // namespace
}  // namespace polhode::platform::plan_test
