#include "recording/export.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "camera/replay/file_camera.hpp"
#include "errors.hpp"
#include "recordings.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::export_test {
namespace {

using namespace recordings;

TEST(Export, LeavesOutFramesWhoseTimesRunBack_AndReportsIt) {
  const TemporaryFolder folder;
  {
    Recorder recorder(options(folder.path()), kBegin, kFrameBytes);
    for (const std::int64_t time_ns :
         {10'000'000, 30'000'000, 20'000'000, 30'000'000, 40'000'000}) {
      recorder.frame(frame_of(time_ns, ramp(kWidth * kHeight)));
    }
  }
  const fs::path out = folder.path() / "out";
  const ExportReport report = export_run(recorded_runs(folder.path()).back(), out);
  EXPECT_EQ(report.frames, 3U);
  EXPECT_EQ(report.out_of_time, 2U);
  EXPECT_FALSE(replays_to_the_same_bytes(report));
  EXPECT_EQ(open_sequence(out).frames.size(), 3U);
}

TEST(Export, IsASequenceWithTheSamePixelsAndTimes) {
  const TemporaryFolder folder;
  const Pixels shallow = noise(1, kWidth * kHeight);
  const Pixels deep = noise(2, kFrameBytes);
  const Pixels packet{0xAB, 0x01};
  {
    Recorder recorder(options(folder.path() / "rec"), kBegin, kFrameBytes);
    recorder.frame(frame_of(1'000'000, shallow));
    recorder.frame({.timestamp_ns = 2'000'000, .image = {}, .readable = false});
    recorder.command(packet);
    recorder.frame(frame_of(3'000'000, deep, PixelFormat::kGray16));
    recorder.dropped(DropReason::kLate, 2);
  }
  const fs::path out = folder.path() / "seq";
  const ExportReport report = export_run(recorded_runs(folder.path() / "rec").back(), out);
  EXPECT_EQ(report.frames, 3U);
  EXPECT_EQ(report.unreadable, 1U);
  EXPECT_EQ(report.dropped, 2U);
  EXPECT_EQ(report.commands, 1U);
  EXPECT_TRUE(replays_to_the_same_bytes(report));
  const Sequence sequence = open_sequence(out);
  EXPECT_EQ(sequence.camera.fv_px, 101.0);
  EXPECT_EQ(sequence.camera.k1, 0.1);
  FileCamera camera(sequence);
  Frame frame;
  ASSERT_TRUE(camera.next(frame));
  EXPECT_EQ(frame.timestamp_ns, 1'000'000);
  EXPECT_TRUE(std::equal(shallow.begin(), shallow.end(), frame.image.data));
  ASSERT_TRUE(camera.next(frame));
  EXPECT_FALSE(frame.readable);
  ASSERT_TRUE(camera.next(frame));
  EXPECT_EQ(frame.image.format, PixelFormat::kGray16);
  EXPECT_TRUE(std::equal(deep.begin(), deep.end(), frame.image.data));
  std::ifstream commands(out / "commands.csv");
  std::string line;
  std::getline(commands, line);
  std::getline(commands, line);
  EXPECT_EQ(line, "3000000,ab01");
}

TEST(Export, OverwritesNothing) {
  const TemporaryFolder folder;
  {
    Recorder(options(folder.path() / "rec"), kBegin, kFrameBytes)
        .frame(frame_of(1, ramp(kWidth * kHeight)));
  }
  folder.write("seq/mine.txt", "x");
  EXPECT_THROW((void)export_run(recorded_runs(folder.path() / "rec").back(), folder.path() / "seq"),
               UnusableInput);
}

TEST(Export, NamesTheFilesThatAreNotInTheRecording) {
  const TemporaryFolder folder;
  const std::string digest(64, 'a');
  {
    Recorder recorder(
        options(folder.path() / "recording"), begin_text("1", digest, kBegin), kFrameBytes);
    recorder.frame(frame_of(1, ramp(kFrameBytes / 2)));
  }
  const ExportReport report =
      export_run(recorded_runs(folder.path() / "recording").back(), folder.path() / "out");
  EXPECT_EQ(report.own_structure_sha256, digest);
  EXPECT_FALSE(replays_to_the_same_bytes(report));
}

TEST(Export, ReportsWhenTheBytesWillDiffer) {
  EXPECT_TRUE(replays_to_the_same_bytes({.has_begin = true}));
  EXPECT_FALSE(replays_to_the_same_bytes({.has_begin = false}));
  EXPECT_FALSE(replays_to_the_same_bytes({.not_recorded = 1, .has_begin = true}));
  EXPECT_FALSE(replays_to_the_same_bytes({.bytes_lost = 1, .has_begin = true}));
  EXPECT_FALSE(replays_to_the_same_bytes({.files_lost = 1, .has_begin = true}));
}

TEST(Export, NamesWhatARecordingHasLost) {
  EXPECT_EQ(losses_of({.dropped = 3, .has_begin = true}), "");
  EXPECT_EQ(losses_of({.not_recorded = 2, .out_of_time = 1, .bytes_lost = 41, .files_lost = 1}),
            "its beginning has been removed, 41 octets damaged, 1 files missing or not to be read, "
            "2 frames not recorded, 1 frames out of time");
}

}  // namespace
}  // namespace polhode::platform::export_test
