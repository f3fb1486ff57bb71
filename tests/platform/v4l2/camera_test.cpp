#include <gtest/gtest.h>

#include "camera/v4l2/v4l2_camera.hpp"
#include "fake_device.hpp"

namespace polhode::platform::camera_test {
namespace {

constexpr int kWait_ms = 20;

V4l2Options options() {
  return {.request = {.path = "/dev/video9",
                      .format = {.width_px = 64, .height_px = 48},
                      .rate_hz = 10.0,
                      .buffers = 4}};
}

class V4l2CameraTest : public testing::Test {
 protected:
  void take_frame(std::uint8_t level, std::uint32_t flags = 0, std::uint32_t bytes_short = 0) {
    device.time_ns += 1'000'000;
    ASSERT_TRUE(device.take_frame(level, flags, bytes_short));
  }

  /// Calls until a frame comes, for at most `limit_ms` of the device's time.
  bool frame_within(V4l2Camera& camera, int limit_ms, Frame* out) {
    const std::int64_t end_ns = device.time_ns + std::int64_t{limit_ms} * 1'000'000;
    while (device.time_ns <= end_ns) {
      if (device.streaming && device.queued() > 0) {
        device.time_ns += 1'000'000;
        (void)device.take_frame(9);
      }
      if (camera.next(kWait_ms, out) == Arrival::kFrame) {
        return true;
      }
    }
    return false;
  }

  FakeDevice device;
  Frame frame;
};

TEST_F(V4l2CameraTest, OneFrameStampedFarAhead_PutsTenAfterItOutOfTime_AndNoMore) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  const std::int64_t now_ns = device.time_ns;
  device.time_ns += 3'600'000'000'000;
  take_frame(1);
  device.time_ns = now_ns;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  for (std::uint8_t level = 2; level <= 10; ++level) {
    take_frame(level);
    ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  }
  for (std::uint8_t level = 11; level <= 13; ++level) {
    take_frame(level);
    ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
    EXPECT_EQ(frame.image.data[0], level);
    EXPECT_EQ(frame.timestamp_ns, device.time_ns);
  }
  EXPECT_EQ(camera.counters().frames_out_of_time, 9U);
}

TEST_F(V4l2CameraTest, HandsOutFramesWhereTheyLie_WithTheTimeOfMidExposure) {
  V4l2Options wanted = options();
  wanted.exposure_ns = 8'000'000;
  wanted.readout_ns = 300'000;
  wanted.clock_offset_ns = 5'000'000'000;
  V4l2Camera camera(device, wanted);
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 80);
  take_frame(42);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_TRUE(frame.readable);
  EXPECT_EQ(frame.image.data[1234], 42);
  EXPECT_EQ(frame.timestamp_ns, 5'000'000'000 + device.time_ns - 4'300'000);
  EXPECT_EQ(device.queued(), 3U);  // the estimator looks at the fourth
}

TEST_F(V4l2CameraTest, AFrameIsAvailableFromWhenItWasFilled_NotFromWhenItWasAskedFor) {
  V4l2Options wanted = options();
  wanted.exposure_ns = 8'000'000;
  V4l2Camera camera(device, wanted);
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1);
  const std::int64_t filled_ns = device.time_ns;
  device.time_ns += 30'000'000;  // the estimator is at the one before
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(camera.available_ns(), filled_ns);
  device.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  take_frame(2);
  const std::int64_t begun_ns = device.time_ns;
  device.time_ns += 30'000'000;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(camera.available_ns(), begun_ns + 8'000'000);
}

TEST_F(V4l2CameraTest, AStampThatCannotBeOfThisClockDoesNotTellWhenTheFrameWasThere) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  const std::int64_t now_ns = device.time_ns;
  device.time_ns += 5'000'000;
  take_frame(1);
  device.time_ns = now_ns;  // stamped in the future
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(camera.available_ns(), now_ns);
}

// verifies: LIV-10
TEST_F(V4l2CameraTest, DamagedAndShortFramesAreAnsweredAsUnreadable) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1, V4L2_BUF_FLAG_ERROR);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_FALSE(frame.readable);
  EXPECT_EQ(frame.image.data, nullptr);
  take_frame(2, 0, 1);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_FALSE(frame.readable);
  take_frame(3);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_TRUE(frame.readable);
  EXPECT_EQ(camera.counters().frames, 3U);
  EXPECT_EQ(camera.counters().frames_damaged, 2U);
}

TEST_F(V4l2CameraTest, GapsInTheDevicesNumbersAreCounted) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1);
  device.lose_frames(5);
  take_frame(2);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(camera.counters().frames_missing, 5U);
}

TEST_F(V4l2CameraTest, PassesOverOldFramesWhenTheEstimatorIsLate_AndCountsThem) {
  V4l2Camera camera(device, options());  // one may wait
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  for (std::uint8_t level = 1; level <= 4; ++level) {
    take_frame(level);
  }
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(frame.image.data[0], 3);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(frame.image.data[0], 4);
  EXPECT_EQ(camera.counters().frames_late, 2U);
}

TEST_F(V4l2CameraTest, WithRoomForAllItPassesOverNone) {
  V4l2Options patient = options();
  patient.backlog_frames_max = 4;
  V4l2Camera camera(device, patient);
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  for (std::uint8_t level = 1; level <= 4; ++level) {
    take_frame(level);
  }
  for (std::uint8_t level = 1; level <= 4; ++level) {
    ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
    EXPECT_EQ(frame.image.data[0], level);
  }
  EXPECT_EQ(camera.counters().frames_late, 0U);
}

TEST_F(V4l2CameraTest, AFrameThatIsNotLaterThanTheLastIsPassedOver) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1);
  ASSERT_TRUE(device.take_frame(2));  // at the same time
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  EXPECT_EQ(camera.counters().frames_out_of_time, 1U);
  take_frame(3);
  EXPECT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
}

TEST_F(V4l2CameraTest, ComesBackAfterAFatalStreamingError) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  ASSERT_TRUE(frame_within(camera, 100, &frame));
  device.failed = true;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  EXPECT_EQ(camera.counters().stream_errors, 1U);
  EXPECT_TRUE(frame_within(camera, 200, &frame));
  EXPECT_EQ(camera.counters().opened, 2U);
  EXPECT_EQ(device.open_now, 1);
}

// verifies: LIV-09
TEST_F(V4l2CameraTest, FindsAnUnpluggedDeviceWithinTheLongestBackOffOfItsReturn) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  for (std::uint32_t cycle = 1; cycle <= 10; ++cycle) {
    ASSERT_TRUE(frame_within(camera, 100, &frame)) << cycle;
    device.gone = true;
    device.open_answer = -ENOENT;
    ASSERT_FALSE(frame_within(camera, 7000, &frame)) << cycle;  // away for seven seconds
    EXPECT_EQ(camera.counters().disconnects, cycle);
    device.open_answer = FakeDevice::kDescriptor;
    const std::int64_t back_ns = device.time_ns;
    ASSERT_TRUE(frame_within(camera, 2000, &frame)) << cycle;
    EXPECT_LE(device.time_ns - back_ns, Backoff::kLongest_ns + 50'000'000) << cycle;
    EXPECT_EQ(device.open_now, 1);
    EXPECT_EQ(device.mapped_now, 4U);
  }
  EXPECT_LT(device.open_count, 10 * 15);  // bounded: about 12 attempts in seven seconds
}

TEST_F(V4l2CameraTest, WaitsForADeviceThatAnotherProgramHolds) {
  V4l2Camera camera(device, options());
  device.answers[VIDIOC_REQBUFS] = -EBUSY;
  EXPECT_EQ(camera.open(), OpenResult::kBusy);
  EXPECT_FALSE(frame_within(camera, 3000, &frame));
  EXPECT_GE(camera.counters().busy, 3U);
  EXPECT_NE(camera.state().find("busy"), std::string_view::npos);
  device.answers.clear();
  EXPECT_TRUE(frame_within(camera, 1500, &frame));
}

TEST_F(V4l2CameraTest, AStreamThatFallsSilentIsOpenedAgain) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  for (int i = 0; i < 200 && camera.counters().opened < 2; ++i) {
    EXPECT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  }
  EXPECT_EQ(camera.counters().opened, 2U);
  EXPECT_GE(camera.counters().timeouts, 100U);  // 2 s in steps of 20 ms
}

TEST_F(V4l2CameraTest, AStreamThatPausesIsLeftAlone_AndAFrameEndsTheSilence) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  for (int round = 0; round < 3; ++round) {
    take_frame(1);
    ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
    EXPECT_EQ(camera.available_ns(), device.time_ns);
    for (int i = 0; i < 90; ++i) {  // 1.8 s of the 2 s allowed
      EXPECT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
    }
  }
  EXPECT_EQ(camera.counters().opened, 1U);
}

TEST_F(V4l2CameraTest, ALongStepIsNoSilenceOfTheDevice) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  device.time_ns += 60'000'000'000;  // the estimator takes a minute
  EXPECT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  EXPECT_EQ(camera.counters().stream_errors, 0U);
}

TEST_F(V4l2CameraTest, DoesNotTakeAnotherFormatWhenItComesBack) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  device.gone = true;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  device.row_padding = 16;
  EXPECT_FALSE(frame_within(camera, 3000, &frame));
  EXPECT_NE(camera.state().find("another format"), std::string_view::npos);
  device.row_padding = 0;
  EXPECT_TRUE(frame_within(camera, 1500, &frame));
}

// verifies: LIV-09
TEST_F(V4l2CameraTest, FindsTheDeviceThatCameBackUnderAnotherNumber) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  device.gone = true;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  device.node = "/dev/video12";
  ASSERT_TRUE(frame_within(camera, 1500, &frame));
  EXPECT_EQ(camera.state(), "streaming: /dev/video12");
  device.gone = true;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  device.node = "/dev/video9";
  ASSERT_TRUE(frame_within(camera, 1500, &frame));
  EXPECT_EQ(camera.state(), "streaming");
  EXPECT_EQ(device.open_now, 1);
}

// verifies: LIV-09
TEST_F(V4l2CameraTest, DoesNotTakeAnotherDeviceForItsOwn_NorSetAnythingThere) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  device.gone = true;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  device.stranger = "/dev/video9";  // has taken its number
  device.node = "nowhere";
  EXPECT_FALSE(frame_within(camera, 5000, &frame));
  EXPECT_EQ(camera.state(), "another device: /dev/video9 is not the one before");
  EXPECT_EQ(device.open_now, 0);
  device.node = "/dev/video3";
  EXPECT_TRUE(frame_within(camera, 1500, &frame));
  for (const unsigned long request : device.strangers_requests) {
    EXPECT_EQ(request, VIDIOC_QUERYCAP);
  }
}

TEST_F(V4l2CameraTest, AtStartItLooksNowhereElse) {
  device.node = "/dev/video3";
  V4l2Camera camera(device, options());
  EXPECT_EQ(camera.open(), OpenResult::kAbsent);
  EXPECT_EQ(device.open_count, 0);
}

TEST_F(V4l2CameraTest, UnpluggedWhileTheEstimatorLooksAtAFrame) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  device.gone = true;
  EXPECT_EQ(frame.image.data[0], 1);  // still mapped
  EXPECT_EQ(camera.next(kWait_ms, &frame), Arrival::kNothing);
  EXPECT_EQ(device.mapped_now, 0U);
  EXPECT_EQ(camera.counters().disconnects, 1U);
}

TEST_F(V4l2CameraTest, SetsExposureAgainAfterTheDeviceCameBack) {
  V4l2Camera camera(device, options());
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  camera.set_exposure(12'300'000, 0.5);
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 123);
  EXPECT_EQ(device.controls[V4L2_CID_GAIN], 501);  // 500.5 of 1 .. 1000
  device.gone = true;
  (void)camera.next(kWait_ms, &frame);
  device.controls.clear();
  ASSERT_TRUE(frame_within(camera, 1500, &frame));
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 123);
}

TEST_F(V4l2CameraTest, TellsHowItIsSet_AndThatItCannotExposeLongerThanAFrame) {
  V4l2Options wanted = options();
  wanted.exposure_ns = 8'000'000;
  wanted.gain = 0.25;
  V4l2Camera camera(device, wanted);
  EXPECT_FALSE(camera.exposure().settable) << "not open yet";
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  const CameraExposure now = camera.exposure();
  ASSERT_TRUE(now.settable);
  EXPECT_EQ(now.exposure_ns, 8'000'000);
  EXPECT_EQ(now.exposure_min_ns, 100'000);
  EXPECT_LE(now.exposure_max_ns, 100'000'000);  // 10 Hz, also the end of the control's range
  ASSERT_TRUE(now.has_gain);
  EXPECT_NEAR(now.gain, 0.25, 1e-3);
}

TEST_F(V4l2CameraTest, ABufferFilledBeforeAChangeHasTheExposureFromBeforeIt) {
  V4l2Options wanted = options();
  wanted.exposure_ns = 8'000'000;
  V4l2Camera camera(device, wanted);
  ASSERT_EQ(camera.open(), OpenResult::kStreaming);
  take_frame(1);
  const std::int64_t before_ns = device.time_ns;
  device.time_ns += 1'000'000;
  camera.set_exposure(2'000'000, -1.0);
  device.time_ns += 20'000'000;
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(frame.timestamp_ns, before_ns - 4'000'000);
  take_frame(2);
  ASSERT_EQ(camera.next(kWait_ms, &frame), Arrival::kFrame);
  EXPECT_EQ(frame.timestamp_ns, device.time_ns - 1'000'000);
}

}  // namespace
}  // namespace polhode::platform::camera_test
