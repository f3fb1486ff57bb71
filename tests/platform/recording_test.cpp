#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "base/crc.hpp"
#include "errors.hpp"
#include "output_file.hpp"
#include "recordings.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::recording_test {
namespace {

using namespace recordings;

TEST(Recording, GivesFramesDropsAndCommandsBackInTheirOrder) {
  const TemporaryFolder folder;
  const Pixels shallow = noise(1, kWidth * kHeight);
  const Pixels deep = ramp(kFrameBytes);
  const Pixels packet{1, 2, 3};
  {
    Recorder recorder(options(folder.path()), kBegin, kFrameBytes);
    recorder.frame(frame_of(10, shallow));
    recorder.dropped(DropReason::kLate, 3);
    recorder.command(packet);
    recorder.frame(frame_of(20, deep, PixelFormat::kGray16));
    recorder.frame({.timestamp_ns = 30, .image = {}, .readable = false});
  }
  const auto records = read_all(folder.path());
  ASSERT_EQ(records.size(), 6U);
  EXPECT_EQ(records[0].header.kind, RecordKind::kBegin);
  EXPECT_EQ(std::string(records[0].content.begin(), records[0].content.end()), kBegin);
  EXPECT_EQ(records[1].header.timestamp_ns, 10);
  EXPECT_EQ(records[1].content, shallow);
  EXPECT_EQ(records[1].header.packing, RecordPacking::kRaw);
  EXPECT_EQ(records[2].header.kind, RecordKind::kDropped);
  EXPECT_EQ(records[2].header.count, 3U);
  EXPECT_EQ(records[3].content, packet);
  EXPECT_EQ(records[4].content, deep);
  EXPECT_EQ(records[4].header.packing, RecordPacking::kDifferenceLz4);
  EXPECT_TRUE(records[4].header.deep);
  EXPECT_FALSE(records[5].header.readable);
  EXPECT_EQ(records[5].header.timestamp_ns, 30);
}

TEST(Recording, PaddedRowsAreStoredWithoutTheirPadding) {
  const TemporaryFolder folder;
  const Pixels padded = noise(2, (kWidth + 10) * kHeight);
  Frame frame = frame_of(10, padded);
  frame.image.stride_bytes = kWidth + 10;
  { Recorder(options(folder.path()), kBegin, kFrameBytes).frame(frame); }
  const auto records = read_all(folder.path());
  ASSERT_EQ(records.size(), 2U);
  ASSERT_EQ(records[1].content.size(), static_cast<std::size_t>(kWidth * kHeight));
  EXPECT_EQ(records[1].content[3 * kWidth + 5], padded[3 * (kWidth + 10) + 5]);
}

TEST(Recording, StaysWithinItsBound_TheOldestGoFirst) {
  const TemporaryFolder folder;
  RecorderOptions bounded = options(folder.path());
  bounded.limits = {.segment_bytes_max = 20'000, .folder_bytes_max = 100'000};
  {
    Recorder recorder(bounded, kBegin, kFrameBytes);
    for (int i = 0; i < 200; ++i) {  // 600 kB
      recorder.frame(frame_of(i, noise(static_cast<std::uint64_t>(i), kWidth * kHeight)));
    }
  }
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    bytes += entry.file_size();
    EXPECT_LE(entry.file_size(), 20'000U);
  }
  EXPECT_LE(bytes, 100'000U);
  EXPECT_GE(bytes, 60'000U);
  const auto records = read_all(folder.path());
  EXPECT_EQ(records.front().header.kind, RecordKind::kBegin);
  EXPECT_EQ(records.back().header.timestamp_ns, 199);
  EXPECT_FALSE(recorded_runs(folder.path()).back().begins);
}

TEST(Recording, AnEarlierRunsFilesCountAndGoFirst) {
  const TemporaryFolder folder;
  RecorderOptions run = options(folder.path());
  run.limits = {.segment_bytes_max = 20'000, .folder_bytes_max = 100'000};
  for (int n = 0; n < 3; ++n) {
    run.run_utc_ns = 1000 + n;
    Recorder recorder(run, kBegin, kFrameBytes);
    for (int i = 0; i < 15; ++i) {
      recorder.frame(frame_of(i, noise(static_cast<std::uint64_t>(i), kWidth * kHeight)));
    }
  }
  const auto runs = recorded_runs(folder.path());
  EXPECT_EQ(runs.back().utc_ns, 1002);
  EXPECT_TRUE(runs.back().begins);
  EXPECT_FALSE(runs.front().begins);
}

TEST(Recording, ADiskThatIsTooSlowCostsFrames_CountedAndWrittenDown) {
  const TemporaryFolder folder;
  RecorderOptions hasty = options(folder.path());
  hasty.complete = false;
  hasty.slots = 2;
  RecorderCounters counters;
  constexpr std::uint64_t kFrames = 400;
  {
    Recorder recorder(hasty, kBegin, kFrameBytes);
    const Pixels pixels = noise(1, kWidth * kHeight);
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      recorder.frame(frame_of(static_cast<std::int64_t>(i), pixels));
    }
    counters = recorder.counters();
  }
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;
  for (const Record& record : read_all(folder.path())) {
    frames += record.header.kind == RecordKind::kFrame ? 1 : 0;
    missed += record.header.reason == DropReason::kNotRecorded ? record.header.count : 0;
  }
  EXPECT_GT(counters.missed, 0U);
  EXPECT_LE(missed, counters.missed);  // those at the very end find nobody to write them down
  EXPECT_EQ(frames + counters.missed, kFrames);
}

/// As a full disk: no file of the process grows beyond this while it lives.
class FullDisk {
 public:
  explicit FullDisk(std::uintmax_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit full{.rlim_cur = bytes, .rlim_max = before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &full);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

// verifies: LIV-08
TEST(Recording, WhatAFullDiskRefusesIsWrittenDown_OnceThereIsRoom) {
  const TemporaryFolder folder;
  const Pixels pixels = noise(1, kWidth * kHeight);
  {
    Recorder recorder(options(folder.path()), kBegin, kFrameBytes);
    std::int64_t time_ns = 0;
    const auto settled = [&](auto RecorderCounters::*counter, std::uint64_t count) {
      while (recorder.counters().*counter < count) {
        std::this_thread::yield();
      }
    };
    recorder.frame(frame_of(++time_ns, pixels));
    settled(&RecorderCounters::frames, 1);
    {
      const FullDisk full(fs::file_size(segment_files(folder.path()).front()));
      for (int i = 0; i < 3; ++i) {
        recorder.frame(frame_of(++time_ns, pixels));
      }
      settled(&RecorderCounters::write_failures, 3);
    }
    recorder.frame(frame_of(++time_ns, pixels));
  }
  std::uint64_t bytes_lost = 0;
  const auto records = read_all(folder.path(), &bytes_lost);
  EXPECT_EQ(bytes_lost, 0U);
  ASSERT_EQ(records.size(), 4U);
  EXPECT_EQ(records[2].header.reason, DropReason::kNotRecorded);
  EXPECT_EQ(records[2].header.count, 3U);
  EXPECT_EQ(records[3].header.timestamp_ns, 5);
}

TEST(Recording, AFileThatTheDiskDoesNotLetBeginIsNotLeftBehind) {
  const TemporaryFolder folder;
  const Pixels pixels = noise(1, kWidth * kHeight);
  {
    Recorder recorder(options(folder.path()), kBegin, kFrameBytes);
    {
      const FullDisk full(0);
      recorder.frame(frame_of(1, pixels));
      while (recorder.counters().write_failures < 1) {
        std::this_thread::yield();
      }
    }
    recorder.frame(frame_of(2, pixels));
  }
  ASSERT_EQ(segment_files(folder.path()).size(), 1U);
  const auto records = read_all(folder.path());
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records[0].header.kind, RecordKind::kBegin);
  EXPECT_EQ(records[1].header.count, 1U);
  EXPECT_EQ(records[2].header.timestamp_ns, 2);
}

class DamagedRecording : public testing::Test {
 protected:
  DamagedRecording() {
    Recorder recorder(options(folder_.path()), kBegin, kFrameBytes);
    for (int i = 0; i < 10; ++i) {
      recorder.frame(frame_of(i, noise(static_cast<std::uint64_t>(i), kWidth * kHeight)));
    }
  }
  [[nodiscard]] fs::path file() const { return segment_files(folder_.path()).front(); }
  [[nodiscard]] std::string bytes() const {
    std::ifstream in(file(), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void replace(const std::string& bytes) const {
    std::ofstream(file(), std::ios::binary | std::ios::trunc) << bytes;
  }
  TemporaryFolder folder_;
};

TEST_F(DamagedRecording, OneFlippedBitCostsOneFrame) {
  const std::string good = bytes();
  const std::size_t record = kRecordHeaderBytes + kWidth * kHeight;
  const std::size_t begin = kRecordHeaderBytes + std::string(kBegin).size();
  for (const std::size_t where : {std::size_t{2}, std::size_t{20}, kRecordHeaderBytes + 100}) {
    std::string damaged = good;
    damaged[begin + 4 * record + where] =
        static_cast<char>(damaged[begin + 4 * record + where] ^ 16);
    replace(damaged);
    std::uint64_t lost = 0;
    const auto records = read_all(folder_.path(), &lost);
    EXPECT_EQ(records.size(), 10U) << where;  // 1 + 10 - 1
    EXPECT_EQ(lost, record) << where;
    EXPECT_EQ(records[4].header.timestamp_ns, 3);
    EXPECT_EQ(records[5].header.timestamp_ns, 5);
  }
}

TEST_F(DamagedRecording, ATornEndCostsTheLastFrame_WhereverItIsTorn) {
  const std::string good = bytes();
  for (const std::size_t cut : {1U, 500U, static_cast<unsigned>(kWidth * kHeight), 3100U}) {
    replace(good.substr(0, good.size() - cut));
    std::uint64_t lost = 0;
    EXPECT_EQ(read_all(folder_.path(), &lost).size(), 10U) << cut;
    EXPECT_EQ(lost, kRecordHeaderBytes + kWidth * kHeight - cut);
  }
}

TEST_F(DamagedRecording, RubbishIsNoRecording) {
  Rng rng(5, 5);
  std::string rubbish(50'000, '\0');
  for (char& byte : rubbish) {
    byte = static_cast<char>(rng.below(256));
  }
  replace(rubbish);
  EXPECT_TRUE(read_all(folder_.path()).empty());
  const TemporaryFolder empty;
  EXPECT_THROW((void)recorded_runs(empty.path()), UnusableInput);
  EXPECT_THROW((void)recorded_runs(empty.path() / "absent"), UnusableInput);
}

TEST(Recording, ACommandThatFindsNoPlaceIsCountedAndWrittenDown_AtTheEndToo) {
  const TemporaryFolder folder;
  RecorderOptions few = options(folder.path());
  few.complete = false;
  few.slots = 2;
  few.limits.folder_bytes_max =
      1'000'000'000;  // no file makes room for another, however many frames find a place
  std::uint64_t missed = 0;
  {
    Recorder recorder(few, kBegin, kFrameBytes);
    const std::vector<std::uint8_t> packet(2000, 7);
    recorder.frame(frame_of(1, noise(1, kFrameBytes / 2)));
    for (int i = 0; i < 20000; ++i) {
      recorder.dropped(DropReason::kLate, 1);
      recorder.frame(frame_of(2 + i, noise(1, kFrameBytes / 2)));
    }
    recorder.command(packet);
    missed = recorder.counters().missed;
  }
  std::uint64_t reported = 0;
  for (const Record& record : read_all(folder.path())) {
    reported += record.header.reason == DropReason::kNotRecorded &&
                        record.header.kind == RecordKind::kDropped
                    ? record.header.count
                    : 0;
  }
  EXPECT_EQ(reported, missed);
}

/// Writes a recording of one frame whose header indicates what is wanted; all checksums are right.
void write_frame_of(const fs::path& folder, RecordHeader header, std::size_t content_bytes) {
  const std::vector<std::uint8_t> content(content_bytes, 0x1F);
  header.kind = RecordKind::kFrame;
  header.bytes = static_cast<std::uint32_t>(content.size());
  header.content_crc32 = crc32_iso_hdlc(content);
  const auto head = encode(header);
  std::ofstream out(folder / "recording-1-000001.rec", std::ios::binary);
  out.write(reinterpret_cast<const char*>(head.data()), head.size());
  out.write(reinterpret_cast<const char*>(content.data()),
            static_cast<std::streamsize>(content.size()));
}

TEST(Recording, ASizeThatNoFrameHasIsPassedOver_BeforeMemoryIsAskedFor) {
  constexpr auto kPacked = RecordPacking::kDifferenceLz4;
  for (const RecordHeader& header :
       {RecordHeader{.packing = kPacked, .width_px = 0, .height_px = 48},
        RecordHeader{.packing = kPacked, .width_px = 64, .height_px = 0},
        RecordHeader{.width_px = 0, .height_px = 0},
        RecordHeader{.deep = true, .packing = kPacked, .width_px = 65535, .height_px = 65535},
        RecordHeader{.deep = true, .packing = kPacked, .width_px = 8192, .height_px = 8192},
        RecordHeader{.packing = static_cast<RecordPacking>(7), .width_px = 64, .height_px = 48}}) {
    const TemporaryFolder folder;
    write_frame_of(folder.path(), header, 40'000);
    std::uint64_t lost = 0;
    EXPECT_TRUE(read_all(folder.path(), &lost).empty()) << header.width_px;
    EXPECT_EQ(lost, kRecordHeaderBytes + 40'000U);
  }
}

TEST(Recording, AFrameLargerThanTheCamerasIsPassedOver) {
  const TemporaryFolder frame;
  write_frame_of(frame.path(), {.width_px = 128, .height_px = 97}, 128 * 97);
  EXPECT_EQ(read_all(frame.path()).size(), 1U);  // without the camera nothing speaks against it
  {
    Recorder recorder(options(frame.path() / "run"), kBegin, kFrameBytes);
    const Pixels pixels(kFrameBytes / 2, 1);
    recorder.frame(frame_of(1, pixels));
  }
  fs::copy(frame.path() / "recording-1-000001.rec", frame.path() / "run/recording-1000-000002.rec");
  std::uint64_t lost = 0;
  EXPECT_EQ(read_all(frame.path() / "run", &lost).size(), 2U);  // the beginning, and the good frame
  EXPECT_EQ(lost, kRecordHeaderBytes + 128U * 97U);
}

TEST(Recording, FilesOfOtherNamesAreNoSegments) {
  const TemporaryFolder folder;
  for (const char* name : {"recording-holiday.rec",
                           "recording-1-2.rec.bak",
                           "recording-.rec",
                           "recording-5.rec",
                           "recording--5.rec",
                           "recording-1-2a.rec",
                           "recording-1-000001.rec"}) {
    folder.write(name, "");
  }
  ASSERT_EQ(segment_files(folder.path()).size(), 1U);
  EXPECT_EQ(segment_files(folder.path()).front().filename(), "recording-1-000001.rec");
}

TEST(Recording, WhatIsWrittenWholeLeavesItsNeighboursAlone) {
  const TemporaryFolder folder;
  const std::string pid = std::to_string(::getpid());
  folder.write("file.new", "the user's");
  folder.write("file." + pid + ".new", "the user's");
  folder.write("file", "old");
  write_file(folder.path() / "file", "new");
  EXPECT_EQ(fs::file_size(folder.path() / "file"), 3U);
  EXPECT_EQ(fs::file_size(folder.path() / "file.new"), 10U);
  EXPECT_EQ(fs::file_size(folder.path() / ("file." + pid + ".new")), 10U);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 3);
}

TEST(Recording, AFileThatIsMissingIsFound) {
  const TemporaryFolder folder;
  RecorderOptions small = options(folder.path());
  small.limits.segment_bytes_max = 20'000;
  {
    Recorder recorder(small, kBegin, kFrameBytes);
    for (int i = 0; i < 40; ++i) {
      recorder.frame(frame_of(i, noise(static_cast<std::uint64_t>(i), kFrameBytes / 2)));
    }
  }
  auto files = recorded_runs(folder.path()).back().files;
  ASSERT_GE(files.size(), 4U);
  EXPECT_EQ(recorded_runs(folder.path()).back().files_missing, 0U);
  fs::remove(files[1]);
  EXPECT_EQ(recorded_runs(folder.path()).back().files_missing, 1U);
}

}  // namespace
}  // namespace polhode::platform::recording_test
