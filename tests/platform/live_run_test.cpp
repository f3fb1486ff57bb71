#include "app/live_run.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <memory>

#include "../pipeline/bench.hpp"
#include "app/exposure_control.hpp"
#include "listener.hpp"
#include "pipeline/job.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::live_run_test {
namespace {

/// Hands out dark frames one after the other, and ends.
class ShortCamera final : public LiveCamera {
 public:
  explicit ShortCamera(int frames) : left_(frames) {}
  Arrival next(int /*timeout_ms*/, Frame* frame) override {
    if (left_-- == 0) {
      return Arrival::kEnded;
    }
    *frame = bench::frame_of(++counted.frames * bench::Bench::kSecond_ns, image_);
    return Arrival::kFrame;
  }
  [[nodiscard]] std::int64_t available_ns() const override { return 0; }
  [[nodiscard]] const CameraCounters& counters() const override { return counted; }
  [[nodiscard]] std::string_view state() const override { return "streaming"; }
  void set_exposure(std::int64_t /*exposure_ns*/, double /*gain*/) override {}

  CameraCounters counted{.opened = 1};

 private:
  int left_;
  bench::Picture image_ = bench::uniform(0);
};

class LiveRun : public testing::Test {
 protected:
  LiveRun() {
    ::setenv("NOTIFY_SOCKET", path_.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "4", 1);  // notified of each stroke
    ::unsetenv("WATCHDOG_PID");
  }
  ~LiveRun() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }

  /// @return strokes of the watchdog.
  int strokes_of_a_run(int frames, Worker& worker) {
    const Listener listener(path_);
    ServiceManager manager;
    LiveReport report(manager, 86400);
    ShortCamera camera(frames);
    LiveParts parts{.component = *bench_.component,
                    .worker = worker,
                    .camera = camera,
                    .manager = manager,
                    .report = report,
                    .counts = counts_,
                    .transports = transports_,
                    .telemetry = telemetry_,
                    .exposure = exposure_};
    EXPECT_EQ(run_live(parts, {}), LiveEnd::kPlayed);
    int strokes = 0;
    for (std::string reported = listener.next(); !reported.empty(); reported = listener.next()) {
      strokes += reported == "WATCHDOG=1" ? 1 : 0;
    }
    return strokes;
  }

  TemporaryFolder folder_;
  std::string path_ = (folder_.path() / "notify").string();
  bench::Bench bench_;
  LiveCounts counts_;
  Transports transports_{TransportSettings{}};
  PlatformTelemetry telemetry_{{}, {}};
  ExposureControl exposure_{ExposureControlOptions{}};
};

// verifies: LIV-06
TEST_F(LiveRun, StrokesTheWatchdogWithSteps) {
  Worker worker({.own_thread = false});
  EXPECT_GT(strokes_of_a_run(3, worker), 0);
  EXPECT_EQ(counts_.frames_accepted, 3U);
}

// verifies: LIV-06
TEST_F(LiveRun, FramesDroppedForAJobThatDoesNotEndAreNoProgress) {
  // The first job is held back by 2.3 s, as the draw for it gives; the frames come in no time.
  Worker worker({.own_thread = true, .latency_ms_max = 3000});
  const auto work = std::make_unique<InitialisationJob>();  // without frames: it ends at once
  Job job{.work = work.get()};
  Jobs jobs;
  (void)jobs.push_back(&job);
  worker.submit(jobs);
  EXPECT_EQ(strokes_of_a_run(3, worker), 0);
  EXPECT_EQ(counts_.frames_dropped_for_job, 3U);
  EXPECT_EQ(counts_.frames_accepted, 0U);
  worker.finish();
}

}  // namespace
}  // namespace polhode::platform::live_run_test
