// A run that ends at any moment and begins again from its checkpoint.
#include "pipeline/checkpoint.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "bench.hpp"
#include "geometry/so3.hpp"
#include "state_of.hpp"

namespace polhode::checkpoint_test {
namespace {

using namespace bench;

constexpr int kFrames = 24;

const Picture& picture(int frame) {
  static const std::vector<Picture> rendered = images_of_turning(kFrames);
  return rendered[static_cast<std::size_t>(frame)];
}

const StepOutput& show(Bench& b, int frame) {
  return b.component->step({.frame = frame_of((frame + 1) * Bench::kSecond_ns, picture(frame))});
}

std::vector<std::uint8_t> saved(const Bench& b) {
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(*b.component, octets));
  return octets;
}

/// A run over the first frames, and what it leaves.
struct Before {
  explicit Before(int frames) : bench(parameters()) {
    for (int i = 0; i < frames; ++i) {
      show(bench, i);
    }
    octets = saved(bench);
  }
  Bench bench;
  std::vector<std::uint8_t> octets;
};

const Before& before_the_end() {
  static const Before run(14);
  return run;
}

// verifies: CMP-08
TEST(Checkpoint, AfterIt_TheTargetIsFoundAtOnce_InTheSameFrame) {
  const Before& run = before_the_end();
  ASSERT_GT(state_of(*run.bench.component).mapping.map.keyframe_count, 0);
  for (const int missed : {0, 3}) {  // frames that went by meanwhile
    Bench b(parameters());
    ASSERT_TRUE(restore_checkpoint(run.octets, b.component));
    const StepOutput& out = show(b, 14 + missed);
    ASSERT_TRUE(out.motion.pose_valid) << missed;
    EXPECT_EQ(out.motion.mode, Mode::kTracking);
    EXPECT_EQ(out.motion.frame, 14U);
    // T is the T from before: its rotation against the truth's is still the same constant one.
    const Eigen::Matrix3d R_TT = turning(14 + missed).R_CT.transpose() * rotation_of(out.motion);
    const Eigen::Matrix3d R_TT_before =
        turning(13).R_CT.transpose() *
        rotation_of(state_of(*run.bench.component).answer.output.motion);
    EXPECT_LT(rotation_angle_rad(R_TT, R_TT_before), 0.035) << missed;
    EXPECT_TRUE(out.motion.rate_valid);
  }
}

TEST(Checkpoint, BeginsWithTheSameTables) {
  const Before& run = before_the_end();
  Bench b(parameters());
  ASSERT_TRUE(restore_checkpoint(run.octets, b.component));
  const Component::State& old = state_of(*run.bench.component);
  const Component::State& now = state_of(*b.component);
  EXPECT_EQ(now.mapping.map.keyframe_count, old.mapping.map.keyframe_count);
  EXPECT_EQ(now.mapping.map.landmark_count, old.mapping.map.landmark_count);
  EXPECT_EQ(now.motion.recent.size(), old.motion.recent.size());
  EXPECT_EQ(now.counters.frames_in, old.counters.frames_in);
  EXPECT_EQ(now.counters.poses, old.counters.poses);
  for (std::size_t i = 0; i < old.mapping.map.landmarks.size(); ++i) {
    ASSERT_EQ(now.mapping.map.landmarks[i].used, old.mapping.map.landmarks[i].used);
    if (old.mapping.map.landmarks[i].used) {
      EXPECT_EQ(now.mapping.map.landmarks[i].number, old.mapping.map.landmarks[i].number);
      EXPECT_EQ(now.mapping.map.landmarks[i].p_T, old.mapping.map.landmarks[i].p_T);
    }
  }
  EXPECT_EQ(saved(b).size(), run.octets.size());
}

TEST(Checkpoint, OfTheSameStateTwoRunsGiveTheSameBytes) {
  const Before& run = before_the_end();
  std::vector<std::vector<std::uint8_t>> packets(2);
  for (auto& bytes : packets) {
    Bench b(parameters());
    ASSERT_TRUE(restore_checkpoint(run.octets, b.component));
    for (int i = 14; i < kFrames; ++i) {
      const StepOutput& out = show(b, i);
      bytes.insert(bytes.end(), out.packets.begin(), out.packets.end());
    }
  }
  EXPECT_EQ(packets[0], packets[1]);
}

TEST(Checkpoint, BeforeThereIsAMap_OnlyCountersAndTimeGoOn) {
  const Before run(2);
  Bench b(parameters());
  ASSERT_TRUE(restore_checkpoint(run.octets, b.component));
  EXPECT_EQ(show(b, 1).use, FrameUse::kTimeNotIncreasing);
  const StepOutput& out = show(b, 2);
  EXPECT_EQ(out.use, FrameUse::kUsed);
  EXPECT_EQ(out.motion.mode, Mode::kAcquiring);
  EXPECT_EQ(out.motion.frame, 3U);
}

TEST(Checkpoint, CutOffOrTooLongOrOfAnotherBuild_ChangesNothing) {
  const Before& run = before_the_end();
  Bench b(parameters());
  const auto refused = [&](std::span<const std::uint8_t> octets) {
    const bool restored = restore_checkpoint(octets, b.component);
    EXPECT_EQ(state_of(*b.component).mapping.map.keyframe_count, 0);
    EXPECT_EQ(b.component->counters().frames_in, 0U);
    return !restored;
  };
  for (const std::size_t length : {std::size_t{0},
                                   std::size_t{8},
                                   std::size_t{100},
                                   run.octets.size() / 2,
                                   run.octets.size() - 1}) {
    EXPECT_TRUE(refused(std::span(run.octets).first(length))) << length;
  }
  std::vector<std::uint8_t> longer = run.octets;
  longer.push_back(0);
  EXPECT_TRUE(refused(longer));
  for (std::size_t octet = 0; octet < 40; octet += 8) {  // the words that tell the layout
    std::vector<std::uint8_t> other = run.octets;
    other[octet] ^= 1;
    EXPECT_TRUE(refused(other)) << octet;
  }
}

}  // namespace
}  // namespace polhode::checkpoint_test
