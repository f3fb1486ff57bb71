#include "camera/replay/played_sequence.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "camera/v4l2/device_calls.hpp"
#include "encode.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::played_sequence_test {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;

/// Five frames at 0, 1, 3, 4, 10 ms; the level of each is its number.
struct Five : TemporaryFolder {
  Five() {
    write("mav0/cam0/sensor.yaml",
          "sensor_type: camera\nresolution: [64, 48]\ncamera_model: pinhole\n"
          "intrinsics: [100.0, 100.0, 31.5, 23.5]\ndistortion_model: radial-tangential\n"
          "distortion_coefficients: [0, 0, 0, 0]\n");
    std::string table = "#timestamp [ns],filename\n";
    for (const int ms : {0, 1, 3, 4, 10}) {
      const std::string name = fmt::format("{}.pgm", frames_);
      const File file =
          encode_pgm(64, 48, 255, File(64 * 48, static_cast<std::uint8_t>(10 + frames_)));
      write("mav0/cam0/data/" + name, {reinterpret_cast<const char*>(file.data()), file.size()});
      table += fmt::format("{},{}\n", 1'000'000'000 + ms * kMillisecond_ns, name);
      ++frames_;
    }
    write("mav0/cam0/data.csv", table);
    sequence = open_sequence(path());
  }
  int frames_ = 0;
  Sequence sequence;
};

TEST(PlayedFrame, GoesForthAndBack_AndTimeGoesOn) {
  const Five five;
  ASSERT_EQ(played_frames(five.sequence, 3), 13U);
  const std::size_t index[] = {0, 1, 2, 3, 4, 3, 2, 1, 0, 1, 2, 3, 4};
  const int ms[] = {0, 1, 3, 4, 10, 16, 17, 19, 20, 21, 23, 24, 30};
  for (std::size_t i = 0; i < 13; ++i) {
    const PlayedFrame played = played_frame(five.sequence, i);
    EXPECT_EQ(played.index, index[i]) << i;
    EXPECT_EQ(played.timestamp_ns, 1'000'000'000 + ms[i] * kMillisecond_ns) << i;
  }
}

TEST(PlayedSequence, WithoutASpeedHandsOutEveryFrame) {
  const Five five;
  PlayedSequence camera(five.sequence, {.speed = 0.0, .passes = 2});
  Frame frame;
  for (const int level : {10, 11, 12, 13, 14, 13, 12, 11, 10}) {
    ASSERT_EQ(camera.next(1, &frame), Arrival::kFrame);
    EXPECT_EQ(frame.image.data[0], level);
  }
  EXPECT_EQ(camera.next(1, &frame), Arrival::kEnded);
  EXPECT_EQ(camera.counters().frames, 9U);
  EXPECT_TRUE(camera.frames_wait());
}

TEST(PlayedSequence, PassesOverFramesThatAreLongDue) {
  const Five five;
  // The last frame was due a second ago; one may wait behind the oldest.
  const std::int64_t now_ns = linux_device_calls().now_ns();
  PlayedSequence camera(five.sequence, {.speed = 1.0, .start_ns = now_ns - 1'010'000'000});
  Frame frame;
  ASSERT_EQ(camera.next(1, &frame), Arrival::kFrame);
  EXPECT_EQ(frame.image.data[0], 13);
  EXPECT_EQ(camera.counters().frames_late, 3U);
  EXPECT_FALSE(camera.frames_wait());
  ASSERT_EQ(camera.next(1, &frame), Arrival::kFrame);
  EXPECT_EQ(camera.next(1, &frame), Arrival::kEnded);
}

TEST(PlayedSequence, WaitsForAFrameThatIsNotDue_NoLongerThanRequested) {
  const Five five;
  const std::int64_t now_ns = linux_device_calls().now_ns();
  PlayedSequence camera(five.sequence,
                        {.speed = 1.0, .start_ns = now_ns + 3600'000 * kMillisecond_ns});
  Frame frame;
  EXPECT_EQ(camera.next(1, &frame), Arrival::kNothing);
  EXPECT_LT(linux_device_calls().now_ns() - now_ns, 60'000 * kMillisecond_ns);
  EXPECT_EQ(camera.counters().timeouts, 1U);
}

TEST(PlayedSequence, HasReadAFrameBeforeItIsDue) {
  Five five;
  DeviceCalls& machine = linux_device_calls();
  PlayedSequence camera(five.sequence,
                        {.speed = 1.0, .start_ns = machine.now_ns() + 500 * kMillisecond_ns});
  Frame frame;
  ASSERT_EQ(camera.next(1, &frame), Arrival::kNothing);
  five.write("mav0/cam0/data/0.pgm", "gone");
  Arrival arrival = Arrival::kNothing;
  while (arrival == Arrival::kNothing) {
    arrival = camera.next(1000, &frame);
  }
  ASSERT_EQ(arrival, Arrival::kFrame);
  EXPECT_TRUE(frame.readable);
  EXPECT_EQ(frame.image.data[0], 10);
}

}  // namespace
}  // namespace polhode::platform::played_sequence_test
