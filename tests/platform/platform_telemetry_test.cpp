#include "app/platform_telemetry.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <vector>

#include "bus/telemetry.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::platform_telemetry_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kFrame_ns = 1'700'000'000'123'456'789;

class CountingCamera final : public LiveCamera {
 public:
  Arrival next(int /*timeout_ms*/, Frame* /*frame*/) override { return Arrival::kNothing; }
  [[nodiscard]] std::int64_t available_ns() const override { return 0; }
  [[nodiscard]] const CameraCounters& counters() const override { return counted; }
  [[nodiscard]] std::string_view state() const override { return {}; }
  void set_exposure(std::int64_t /*exposure_ns*/, double /*gain*/) override {}

  CameraCounters counted;
};

class PlatformTelemetryTest : public testing::Test {
 protected:
  void pass(std::int64_t now_ns) {
    telemetry_.passed(counts_, camera_, transports_, now_ns, kFrame_ns);
  }
  [[nodiscard]] std::vector<std::uint8_t> written() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] std::vector<bus::PlatformPacket> sent() const {
    const std::vector<std::uint8_t> bytes = written();
    std::vector<bus::PlatformPacket> packets(bytes.size() / kBytes);
    EXPECT_EQ(bytes.size() % kBytes, 0U);
    for (std::size_t i = 0; i < packets.size(); ++i) {
      const auto* begin = bytes.data() + i * kBytes;
      const auto header = bus::decode(bus::PlatformPacket::layout(), {begin, kBytes}, &packets[i]);
      EXPECT_TRUE(header) << header.error().message;
      EXPECT_EQ(header.value().sequence, i);
      EXPECT_EQ(header.value().apid, 0x1A0 + 7);
    }
    return packets;
  }

  static constexpr std::size_t kBytes = bus::platform_layout::kPacketOctets;
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "sent";
  Transports transports_{{.send = {"file:" + file_.string()}, .receive = {}}};
  LiveCounts counts_;
  CountingCamera camera_;
  PlatformTelemetry telemetry_{
      {}, {.watchdog = true, .locked_memory = false, .real_time = true, .restarts = 7}};
};

TEST_F(PlatformTelemetryTest, IsSentOnceASecond_HoweverOftenTheLoopTurns) {
  for (std::int64_t now_ns = 5 * kSecond_ns; now_ns <= 8 * kSecond_ns; now_ns += kSecond_ns / 100) {
    pass(now_ns);
  }
  const auto packets = sent();
  ASSERT_EQ(packets.size(), 4U);
  EXPECT_EQ(packets[0].uptime_s, 0U);
  EXPECT_EQ(packets[3].uptime_s, 3U);
  EXPECT_EQ(packets[3].packets_sent, 3U);
}

TEST_F(PlatformTelemetryTest, TellsWhatTheRunHasCounted) {
  counts_.deadline = DeadlineMonitor(1.0);
  (void)counts_.deadline.add(5000);
  (void)counts_.deadline.add(900);
  counts_.last_step_us = 900;
  counts_.frames_dropped_for_job = 2;
  camera_.counted = {.frames_damaged = 1,
                     .frames_missing = 10,
                     .frames_late = 100,
                     .frames_out_of_time = 1000,
                     .stream_errors = 3,
                     .disconnects = 5,
                     .opened = 9};
  pass(kSecond_ns);
  const auto packets = sent();
  ASSERT_EQ(packets.size(), 1U);
  const bus::PlatformPacket& reported = packets[0];
  EXPECT_EQ(reported.timestamp_ns, kFrame_ns);
  EXPECT_EQ(reported.frames_dropped, 1112U);
  EXPECT_EQ(reported.camera_errors, 9U);
  EXPECT_EQ(reported.camera_reopened, 8U);
  EXPECT_EQ(reported.deadline_misses, 1U);
  EXPECT_EQ(reported.jobs_late, 2U);
  EXPECT_EQ(reported.last_step_us, 900U);
  EXPECT_EQ(reported.longest_step_us, 5000U);
  EXPECT_EQ(reported.restarts, 7U);
  EXPECT_EQ(reported.flags,
            bus::platform_layout::kFlagWatchdog | bus::platform_layout::kFlagRealTime);
  EXPECT_GT(reported.resident_octets, 1'000'000U);
  EXPECT_GE(reported.resident_peak_octets, reported.resident_octets / 2);
}

TEST_F(PlatformTelemetryTest, ADiskThatRefusesIsAnEvent_WithACountOfItsOwn) {
  const WriteFailures failures{.packets = 5, .checkpoints = 1, .records = 123456789, .streamed = 2};
  telemetry_.disk_refused(failures, transports_, kFrame_ns);
  telemetry_.disk_refused(failures, transports_, kFrame_ns);
  const std::vector<std::uint8_t> bytes = written();
  constexpr std::size_t kEvent = bus::platform_event_layout::kPacketOctets;
  ASSERT_EQ(bytes.size(), 2 * kEvent);
  for (std::uint16_t i = 0; i < 2; ++i) {
    bus::PlatformEventPacket event;
    const auto header = bus::decode(
        bus::PlatformEventPacket::layout(), std::span(bytes).subspan(i * kEvent, kEvent), &event);
    ASSERT_TRUE(header) << header.error().message;
    EXPECT_EQ(header.value().apid, 0x1A0 + 9);
    EXPECT_EQ(header.value().sequence, i);
    EXPECT_EQ(event.value, (std::array<double, 4>{5, 1, 123456789, 2}));
    EXPECT_EQ(event.timestamp_ns, kFrame_ns);
    EXPECT_EQ(std::string(event.text.data(), event.text_octets),
              "disk: not written: packets of 5 steps, 1 checkpoints, 123456789 records, 2 packets "
              "of files");
  }
}

}  // namespace
}  // namespace polhode::platform::platform_telemetry_test
