#include "pipeline/component.hpp"

#include <gtest/gtest.h>

#include <string>

#include "bench.hpp"
#include "bus/telemetry.hpp"
#include "tests/bus/motion_packet.hpp"

namespace polhode::component_test {
namespace {

using namespace bench;

/// The motion packet of a step, its first, decoded; it says what the step's motion state says.
MotionState packet_of(const StepOutput& out) {
  EXPECT_GE(out.packets.size(), kMotionPacketOctets);
  const Result<MotionState> decoded = decode_motion(out.packets.first(kMotionPacketOctets));
  EXPECT_TRUE(decoded.ok());
  EXPECT_EQ(decoded.value().frame, out.motion.frame);
  EXPECT_EQ(decoded.value().timestamp_ns, out.motion.timestamp_ns);
  EXPECT_EQ(decoded.value().mode, out.motion.mode);
  EXPECT_EQ(decoded.value().pose_valid, out.motion.pose_valid);
  return decoded.value();
}

int sequence_count(const StepOutput& out) {
  return ((out.packets[2] & 0x3F) << 8) | out.packets[3];
}

// verifies: CMP-03
TEST(ComponentCreate, RefusesAParameterOutOfRange_AndNamesIt) {
  Parameters p = parameters();
  p.features.count_max = 0;
  const Memory memory(memory_needed(p).total);
  const auto made = Component::create(memory.view(), p);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::kBadParameter);
  EXPECT_NE(made.error().message.find("count_max"), std::string::npos) << made.error().message;
}

TEST(ComponentCreate, RefusesAMissingCamera) {
  const Parameters p;
  const Memory memory(memory_needed(p).total);
  const auto made = Component::create(memory.view(), p);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::kBadParameter);
}

TEST(ComponentCreate, RefusesMemoryThatIsTooSmall_OrNotAligned) {
  const Parameters p = parameters();
  const std::size_t need = memory_needed(p).total;
  const Memory memory(need + 64);
  for (const std::span<std::byte> part :
       {memory.view().first(need - 1), memory.view().subspan(8, need), std::span<std::byte>()}) {
    const auto made = Component::create(part, p);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::kMemoryTooSmall);
    EXPECT_FALSE(made.error().message.empty());
  }
  EXPECT_TRUE(Component::create(memory.view().first(need), p).ok());
}

// verifies: CMP-04
TEST(ComponentCreate, StaysWithinTheMemoryThatItAskedFor) {
  const Parameters p = parameters();
  const std::size_t need = memory_needed(p).total;
  const Memory memory(need + 4096);
  Component* component = Component::create(memory.view().first(need), p).value();
  for (int i = 0; i < 3; ++i) {
    const Picture picture = noise(static_cast<std::uint64_t>(i));
    (void)component->step({.frame = frame_of(i + 1, picture)});
  }
  for (const std::byte octet : memory.view().subspan(need)) {
    ASSERT_EQ(octet, std::byte{0xA5});
  }
}

void expect_acquiring(const std::vector<Picture>& pictures) {
  Bench b;
  for (const Picture& picture : pictures) {
    const StepOutput& out = b.show(picture);
    const MotionState m = packet_of(out);
    EXPECT_EQ(m.mode, Mode::kAcquiring);
    EXPECT_FALSE(m.pose_valid || m.rate_valid || m.velocity_valid);
    EXPECT_EQ(m.landmarks, 0);
    EXPECT_EQ(m.keyframes, 0);
  }
  EXPECT_EQ(b.component->counters().poses, 0U);
  EXPECT_EQ(b.component->counters().frames_in, pictures.size());
}

TEST(Step, StaysAcquiring_OnBlack) { expect_acquiring(std::vector<Picture>(5, uniform(0))); }

TEST(Step, StaysAcquiring_OnUniformPictures) {
  expect_acquiring(std::vector<Picture>(5, uniform(128)));
  expect_acquiring(std::vector<Picture>(5, uniform(255)));
}

TEST(Step, StaysAcquiring_OnNoise) {
  std::vector<Picture> pictures;
  for (std::uint64_t i = 0; i < 6; ++i) {
    pictures.push_back(noise(i));
  }
  expect_acquiring(pictures);
}

TEST(Step, StaysAcquiring_OnAStaticPicture) { expect_acquiring(std::vector<Picture>(8, noise(1))); }

TEST(Step, StaysAcquiring_WhenTheBodyDoesNotTurn) {
  expect_acquiring(std::vector<Picture>(8, Ball(1).seen_from({.p_CT = {0.0, 0.0, 8.0}})));
}

// verifies: BUS-04
TEST(Step, AnswersAndCountsEachKindOfBadFrame_WithOneInvalidPacket) {
  Bench b;
  const Picture good = noise(1);
  const Picture black = uniform(0);
  const Picture small(100, 50);
  const auto step = [&](const Frame& frame) -> const StepOutput& {
    return b.component->step({.frame = frame});
  };
  const auto expect = [&](const Frame& frame, FrameUse use) {
    const StepOutput& out = step(frame);
    EXPECT_EQ(out.use, use);
    const MotionState m = packet_of(out);
    EXPECT_FALSE(m.pose_valid);
    EXPECT_EQ(m.timestamp_ns, frame.timestamp_ns);
  };
  expect(frame_of(100, good), FrameUse::kUsed);
  expect(unreadable(200), FrameUse::kUnreadable);
  Frame empty = unreadable(300);
  empty.readable = true;
  expect(empty, FrameUse::kUnreadable);  // said to be readable, yet without an image
  expect(frame_of(400, small, 10, 10), FrameUse::kWrongSize);
  expect(frame_of(500, black), FrameUse::kDark);
  expect(frame_of(500, good), FrameUse::kTimeNotIncreasing);
  expect(frame_of(450, good), FrameUse::kTimeNotIncreasing);
  expect(frame_of(600, good), FrameUse::kUsed);
  const Counters& c = b.component->counters();
  EXPECT_EQ(c.frames_in, 8U);
  EXPECT_EQ(c.frames_used, 2U);
  EXPECT_EQ(c.frames_unreadable, 2U);
  EXPECT_EQ(c.frames_wrong_size, 1U);
  EXPECT_EQ(c.frames_dark, 1U);
  EXPECT_EQ(c.frames_time_not_increasing, 2U);
}

TEST(Step, TakesAnyTimeStamp_AsTheFirst) {
  for (const std::int64_t first :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{1'700'000'000'000'000'000}}) {
    Bench b;
    const Picture picture = noise(1);
    EXPECT_EQ(b.component->step({.frame = frame_of(first, picture)}).use, FrameUse::kUsed);
    const Picture next = noise(2);
    EXPECT_EQ(b.component->step({.frame = frame_of(first + 1, next)}).use, FrameUse::kUsed);
  }
}

void expect_nothing_said(const Frame& frame, const Picture& before) {
  Bench b;
  const StepOutput& seen = b.show(before);
  EXPECT_GT(seen.motion.features, 20);
  EXPECT_FALSE(seen.observations.empty());
  const StepOutput& out = b.component->step({.frame = frame});
  EXPECT_NE(out.use, FrameUse::kUsed);
  EXPECT_EQ(out.motion.features, 0);
  EXPECT_EQ(out.motion.matches, 0);
  EXPECT_TRUE(out.observations.empty());
}

TEST(Step, SaysNothingOfFeatures_ForAFrameThatItDidNotLookAt) {
  const Picture picture = Ball(1).seen_from({.p_CT = {0.0, 0.0, 8.0}});
  expect_nothing_said(unreadable(5 * Bench::kSecond_ns), picture);
  expect_nothing_said(frame_of(5 * Bench::kSecond_ns, picture, 16, 16), picture);
}

TEST(Step, SaysNothingOfFeatures_ForAFrameOfTheSameTime) {
  const Picture picture = Ball(1).seen_from({.p_CT = {0.0, 0.0, 8.0}});
  expect_nothing_said(frame_of(Bench::kSecond_ns, picture), picture);
}

TEST(Step, CountsFramesAndPackets_WithoutAGap) {
  Bench b;
  const Picture picture = uniform(128);
  for (int i = 0; i < 20; ++i) {
    const StepOutput& out =
        i % 3 == 1 ? b.component->step({.frame = unreadable(1)}) : b.show(picture);
    EXPECT_EQ(sequence_count(out), i);
    EXPECT_EQ(out.motion.frame, static_cast<std::uint32_t>(i));
  }
}

// verifies: BUS-05
TEST(Step, WrapsTheCountOfPackets_After14Bits) {
  Bench b;
  int last = -1;
  for (int i = 0; i < 0x4000 + 3; ++i) {
    last = sequence_count(b.component->step({.frame = unreadable(i)}));
    ASSERT_EQ(last, i % 0x4000);
  }
  EXPECT_EQ(last, 2);
}

TEST(Step, TellsTheEndOfTheStagesThatRan_InTheOrderOfTheFlow) {
  Bench b;
  std::vector<Stage> stages;
  b.component->set_stage_hook(
      [](void* context, Stage stage) {
        static_cast<std::vector<Stage>*>(context)->push_back(stage);
      },
      &stages);
  (void)b.show(Ball(1).seen_from({.p_CT = {0.0, 0.0, 8.0}}));
  ASSERT_FALSE(stages.empty());
  EXPECT_EQ(stages.front(), Stage::kImage);
  EXPECT_EQ(stages.back(), Stage::kBus);
  const auto back = std::is_sorted_until(stages.begin(), stages.end());
  EXPECT_TRUE(back == stages.end() || *back == Stage::kMask);
  EXPECT_TRUE(std::is_sorted(back, stages.end()));
  stages.clear();
  (void)b.component->step({.frame = unreadable(5 * Bench::kSecond_ns)});
  EXPECT_EQ(stages, std::vector<Stage>{Stage::kBus});
}

TEST(Step, TakesPicturesOf16Bits_AsTheirUpperOctets) {
  const Picture eight = Ball(1).seen_from({.p_CT = {0.0, 0.0, 8.0}});
  std::vector<std::uint16_t> sixteen;
  for (const std::uint8_t pixel : eight) {
    sixteen.push_back(static_cast<std::uint16_t>(pixel << 8U | 0x5AU));
  }
  Bench a;
  Bench b;
  const StepOutput& from_eight = a.show(eight);
  const StepOutput& from_sixteen = b.component->step(
      {.frame = {.timestamp_ns = Bench::kSecond_ns,
                 .image = {.data = reinterpret_cast<const std::uint8_t*>(sixteen.data()),
                           .width_px = kWidth,
                           .height_px = kHeight,
                           .stride_bytes = 2 * kWidth,
                           .format = PixelFormat::kGray16}}});
  EXPECT_GT(from_eight.motion.features, 20);
  EXPECT_TRUE(std::equal(from_eight.packets.begin(),
                         from_eight.packets.end(),
                         from_sixteen.packets.begin(),
                         from_sixteen.packets.end()));
}

}  // namespace
}  // namespace polhode::component_test
