#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "memory_plan.hpp"

namespace polhode::platform::small_plan_test {
namespace {

/// What the plan depends on, as config/small.toml has it, with a camera of 640x480.
Parameters small_parameters() {
  const toml::table file = toml::parse_file(POLHODE_SMALL_TOML);
  const auto budget = [&](const char* key) { return file["budget"][key].value<int>().value(); };
  Parameters p;
  p.camera.width_px = 640;
  p.camera.height_px = 480;
  p.map.keyframes_max = file["map"]["keyframes_max"].value<int>().value();
  p.map.adjustment_observations_max =
      file["map"]["adjustment_observations_max"].value<int>().value();
  p.mask.background = file["mask"]["background"].value<bool>().value();
  p.jobs.delay_of_all_frames = file["jobs"]["delay_of_all_frames"].value<int>().value();
  p.budget.total_mb = budget("total_mb");
  p.budget.general_mb = budget("general_mb");
  p.budget.step_mb = budget("step_mb");
  p.budget.jobs_mb = budget("jobs_mb");
  p.budget.reserve_mb = budget("reserve_mb");
  return p;
}

constexpr std::size_t kPixels = std::size_t{640} * 480;

TEST(SmallPlan, HoldsAReplayOfFilesThatDoNotCompress) {
  const MachineNeeds needs{.rows = {{"the largest of the frames' files", kPixels + kPixels / 8}},
                           .decoder_bytes = 2 * kPixels};
  EXPECT_EQ(plan_memory(small_parameters(), needs).problem, "");
}

TEST(SmallPlan, HoldsTheBuffersOfAGrayDevice) {
  const MachineNeeds needs{.rows = {{"buffers of the device", 4 * kPixels}}};
  EXPECT_EQ(plan_memory(small_parameters(), needs).problem, "");
}

TEST(SmallPlan, KeepsALargerCameraOut) {
  Parameters p = small_parameters();
  p.camera.width_px = 1280;
  p.camera.height_px = 720;
  EXPECT_NE(plan_memory(p).problem, "");
}

}  // namespace
}  // namespace polhode::platform::small_plan_test
