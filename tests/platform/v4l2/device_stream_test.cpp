#include "camera/v4l2/device_stream.hpp"

#include <gtest/gtest.h>

#include "fake_device.hpp"

namespace polhode::platform::device_stream_test {
namespace {

DeviceRequest request() {
  return {.path = "/dev/video9",
          .format = {.width_px = 64, .height_px = 48},
          .rate_hz = 10.0,
          .buffers = 4};
}

struct Opening {
  const char* what;
  void (*fault)(FakeDevice&);
  OpenResult expected;
};

const Opening kOpenings[] = {
    {"no node", [](FakeDevice& d) { d.open_answer = -ENOENT; }, OpenResult::kAbsent},
    {"node without device", [](FakeDevice& d) { d.open_answer = -ENXIO; }, OpenResult::kAbsent},
    {"not permitted", [](FakeDevice& d) { d.open_answer = -EACCES; }, OpenResult::kFailed},
    {"not a video device",
     [](FakeDevice& d) { d.answers[VIDIOC_QUERYCAP] = -ENOTTY; },
     OpenResult::kUnsuitable},
    {"an output device",
     [](FakeDevice& d) { d.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING; },
     OpenResult::kUnsuitable},
    {"read() only",
     [](FakeDevice& d) { d.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE; },
     OpenResult::kUnsuitable},
    {"another size", [](FakeDevice& d) { d.width = 80; }, OpenResult::kUnsuitable},
    {"a format that nobody reads",
     [](FakeDevice& d) { d.formats = {V4L2_PIX_FMT_SBGGR8}; },
     OpenResult::kUnsuitable},
    {"interlaced", [](FakeDevice& d) { d.field = V4L2_FIELD_INTERLACED; }, OpenResult::kUnsuitable},
    {"interlaced, in planes",
     [](FakeDevice& d) {
       d.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
       d.planes = 1;
       d.field = V4L2_FIELD_ALTERNATE;
     },
     OpenResult::kUnsuitable},
    {"taken by another, told at the format",
     [](FakeDevice& d) { d.answers[VIDIOC_S_FMT] = -EBUSY; },
     OpenResult::kBusy},
    {"taken by another, told at the buffers",
     [](FakeDevice& d) { d.answers[VIDIOC_REQBUFS] = -EBUSY; },
     OpenResult::kBusy},
    {"no memory", [](FakeDevice& d) { d.answers[VIDIOC_REQBUFS] = -ENOMEM; }, OpenResult::kFailed},
    {"one buffer only", [](FakeDevice& d) { d.buffers_given = 1; }, OpenResult::kFailed},
    {"more buffers than V4L2 has",
     [](FakeDevice& d) { d.buffers_given = 33; },
     OpenResult::kFailed},
    {"a buffer that is not there",
     [](FakeDevice& d) { d.answers[VIDIOC_QUERYBUF] = -EINVAL; },
     OpenResult::kFailed},
    {"not to be mapped", [](FakeDevice& d) { d.map_fails = true; }, OpenResult::kFailed},
    {"not to be queued", [](FakeDevice& d) { d.answers[VIDIOC_QBUF] = -EIO; }, OpenResult::kFailed},
    {"does not start",
     [](FakeDevice& d) { d.answers[VIDIOC_STREAMON] = -EINVAL; },
     OpenResult::kFailed},
    {"unplugged while it starts",
     [](FakeDevice& d) { d.answers[VIDIOC_STREAMON] = -ENODEV; },
     OpenResult::kAbsent},
};

TEST(DeviceStream, ReportsWhyItCannotOpen_AndLeavesNothingBehind) {
  for (const Opening& opening : kOpenings) {
    FakeDevice device;
    opening.fault(device);
    {
      DeviceStream stream(device, request());
      EXPECT_EQ(stream.open(), opening.expected) << opening.what;
      EXPECT_FALSE(stream.is_open()) << opening.what;
      EXPECT_NE(stream.trouble().find("/dev/video9"), std::string_view::npos) << opening.what;
    }
    EXPECT_EQ(device.open_now, 0) << opening.what;
    EXPECT_EQ(device.mapped_now, 0U) << opening.what;
  }
}

TEST(DeviceStream, ChecksADeviceWithoutStreaming) {
  FakeDevice device;
  DeviceStream stream(device, request());
  EXPECT_EQ(stream.check(), OpenResult::kStreaming);
  EXPECT_EQ(device.open_now, 0);
  EXPECT_EQ(device.mapped_now, 0U);
  device.width = 80;
  EXPECT_EQ(stream.check(), OpenResult::kUnsuitable);
  device.open_answer = -ENOENT;
  EXPECT_EQ(stream.check(), OpenResult::kAbsent);
}

TEST(DeviceStream, AfterAFaultHasPassedItOpens) {
  FakeDevice device;
  device.answers[VIDIOC_STREAMON] = -EINVAL;
  DeviceStream stream(device, request());
  EXPECT_EQ(stream.open(), OpenResult::kFailed);
  device.answers.clear();
  EXPECT_EQ(stream.open(), OpenResult::kStreaming);
  EXPECT_EQ(device.open_now, 1);
  EXPECT_EQ(device.mapped_now, 4U);
}

TEST(DeviceStream, WithoutRateOrControlsItStreamsAllTheSame) {
  FakeDevice device;
  device.answers[VIDIOC_S_PARM] = -ENOTTY;
  device.has_exposure = false;
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  EXPECT_EQ(stream.rate_hz(), 0.0);
  EXPECT_FALSE(stream.set_exposure(1'000'000));
  EXPECT_FALSE(stream.set_gain(0.5));
}

TEST(DeviceStream, TakesBuffersInOrder_AndTheDeviceUsesThemAgain) {
  FakeDevice device;
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  EXPECT_DOUBLE_EQ(stream.rate_hz(), 10.0);
  for (std::uint8_t round = 1; round <= 20; ++round) {
    ASSERT_TRUE(device.take_frame(round));
    TakenBuffer taken;
    ASSERT_EQ(stream.take(100, &taken), TakeResult::kBuffer);
    EXPECT_EQ(taken.bytes.size(), 64U * 48U);
    EXPECT_EQ(taken.bytes[100], round);
    EXPECT_EQ(taken.sequence, round - 1U);
    EXPECT_EQ(taken.stamp_ns, device.time_ns);
    EXPECT_FALSE(taken.damaged);
    EXPECT_TRUE(stream.give_back(taken.index));
  }
  EXPECT_EQ(device.queued(), 4U);
}

TEST(DeviceStream, WaitsNoLongerThanRequested) {
  FakeDevice device;
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  const std::int64_t before_ns = device.time_ns;
  TakenBuffer taken;
  EXPECT_EQ(stream.take(40, &taken), TakeResult::kNothing);
  EXPECT_EQ(device.time_ns - before_ns, 40'000'000);
  EXPECT_EQ(stream.take(0, &taken), TakeResult::kNothing);
  EXPECT_EQ(device.time_ns - before_ns, 40'000'000);
}

TEST(DeviceStream, SeparatesAFatalErrorFromADeviceThatIsGone) {
  FakeDevice device;
  DeviceStream stream(device, request());
  TakenBuffer taken;
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  device.failed = true;
  EXPECT_EQ(stream.take(10, &taken), TakeResult::kBroken);
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  device.gone = true;
  EXPECT_EQ(stream.take(10, &taken), TakeResult::kGone);
  EXPECT_FALSE(stream.give_back(0));
  stream.close();
  EXPECT_EQ(device.mapped_now, 0U);
}

TEST(DeviceStream, ABufferNumberThatIsNoneIsNotBelieved) {
  FakeDevice device;
  device.buffers_given = 4;
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  device.lie_about_index = 4;
  ASSERT_TRUE(device.take_frame(1));
  TakenBuffer taken;
  EXPECT_EQ(stream.take(10, &taken), TakeResult::kBroken);
}

TEST(DeviceStream, MoreBytesThanTheBufferHasAreCutOff) {
  FakeDevice device;
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  ASSERT_TRUE(device.take_frame(1, 0, static_cast<std::uint32_t>(-1000)));
  TakenBuffer taken;
  ASSERT_EQ(stream.take(10, &taken), TakeResult::kBuffer);
  EXPECT_EQ(taken.bytes.size(), 64U * 48U);
}

TEST(DeviceStream, TakesTheLuminanceOfADeviceWithSeveralPlanes) {
  FakeDevice device;
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  device.planes = 2;
  device.bytes_before = 16;
  device.formats = {V4L2_PIX_FMT_NV12M};
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming) << stream.trouble();
  EXPECT_EQ(stream.format().fourcc, V4L2_PIX_FMT_NV12M);
  EXPECT_EQ(device.mapped_now, 4U);
  for (int i = 0; i < 6; ++i) {  // each buffer comes and goes back
    ASSERT_TRUE(device.take_frame(9));
    TakenBuffer taken;
    ASSERT_EQ(stream.take(10, &taken), TakeResult::kBuffer);
    EXPECT_EQ(taken.bytes.size(), 64U * 48U);
    EXPECT_TRUE(stream.give_back(taken.index));
  }
  stream.close();
  EXPECT_EQ(device.mapped_now, 0U);
}

TEST(DeviceStream, NamesTheFieldsThatItRefuses) {
  FakeDevice device;
  DeviceStream stream(device, request());
  for (const auto& [field, name] :
       {std::pair{V4L2_FIELD_INTERLACED_TB, "gives interlaced;"},
        std::pair{V4L2_FIELD_ALTERNATE, "top and bottom fields in turn"},
        std::pair{V4L2_FIELD_SEQ_BT, "one after the other"},
        std::pair{V4L2_FIELD_TOP, "top fields"}}) {
    device.field = field;
    EXPECT_EQ(stream.open(), OpenResult::kUnsuitable);
    EXPECT_NE(stream.trouble().find(name), std::string_view::npos) << stream.trouble();
  }
  device.field = V4L2_FIELD_ANY;
  EXPECT_EQ(stream.open(), OpenResult::kStreaming);
}

TEST(DeviceStream, KnowsWhatTheTimeStampMarks) {
  FakeDevice device;
  DeviceStream stream(device, request());
  ASSERT_EQ(stream.open(), OpenResult::kStreaming);
  TakenBuffer taken;
  ASSERT_TRUE(device.take_frame(1));
  ASSERT_EQ(stream.take(10, &taken), TakeResult::kBuffer);
  EXPECT_EQ(taken.stamped_at, StampedAt::kEndOfFrame);
  device.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  ASSERT_TRUE(device.take_frame(1));
  ASSERT_EQ(stream.take(10, &taken), TakeResult::kBuffer);
  EXPECT_EQ(taken.stamped_at, StampedAt::kStartOfExposure);
  device.stamp_flags =
      V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;  // of another clock: the driver's own is better
  ASSERT_TRUE(device.take_frame(1));
  device.time_ns += 5;
  ASSERT_EQ(stream.take(10, &taken), TakeResult::kBuffer);
  EXPECT_EQ(taken.stamp_ns, device.time_ns);
}

TEST(Controls, TakeTheNearestSettingWithinTheirRange) {
  const ControlRange range{.present = true, .id = 1, .low = 10, .high = 95, .step = 10};
  EXPECT_EQ(nearest_setting(range, 10.0), 10);
  EXPECT_EQ(nearest_setting(range, 34.0), 30);
  EXPECT_EQ(nearest_setting(range, 36.0), 40);
  EXPECT_EQ(nearest_setting(range, -1e9), 10);
  EXPECT_EQ(nearest_setting(range, 1e9), 90);  // 95 is on no step
}

}  // namespace
}  // namespace polhode::platform::device_stream_test
