#include "camera/replay/sequence.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "camera/replay/file_camera.hpp"
#include "encode.hpp"
#include "errors.hpp"
#include "quote.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::sequence_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr const char* kSensor =
    "sensor_type: camera\nrate_hz: 10\nresolution: [64, 48]\ncamera_model: pinhole\n"
    "intrinsics: [100.0, 101.0, 31.5, 23.5]\ndistortion_model: radial-tangential\n"
    "distortion_coefficients: [0.1, -0.2, 0.001, 0.002]\n";

std::string image(int width = kWidth, int height = kHeight) {
  const File file =
      encode_pgm(width, height, 255, File(static_cast<std::size_t>(width * height), 90));
  return {file.begin(), file.end()};
}

/// A good sequence of three frames, to be spoiled.
struct SequenceFolder : TemporaryFolder {
  SequenceFolder() {
    sensor(kSensor);
    table("#timestamp [ns],filename\n100000000,a.pgm\n200000000,b.pgm\n300000000,c.pgm\n");
    for (const char* name : {"a.pgm", "b.pgm", "c.pgm"}) {
      frame(name, image());
    }
  }
  void sensor(std::string_view text) const { write("mav0/cam0/sensor.yaml", text); }
  void table(std::string_view text) const { write("mav0/cam0/data.csv", text); }
  void frame(const std::string& name, std::string_view text) const {
    write("mav0/cam0/data/" + name, text);
  }
  [[nodiscard]] std::string refusal() const {
    return refusal_of<UnusableInput>([this] { (void)open_sequence(path()); });
  }
};

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

#define EXPECT_HOLDS(text, part) EXPECT_TRUE(holds(text, part)) << text

TEST(Sequence, ReadsCameraAndFrames) {
  const SequenceFolder folder;
  const Sequence sequence = open_sequence(folder.path());
  ASSERT_EQ(sequence.frames.size(), 3U);
  EXPECT_EQ(sequence.frames[1].timestamp_ns, 200000000);
  EXPECT_EQ(sequence.frames[1].file, "b.pgm");
  EXPECT_EQ(sequence.camera.width_px, kWidth);
  EXPECT_EQ(sequence.camera.fv_px, 101.0);
  EXPECT_EQ(sequence.camera.p2, 0.002);
}

TEST(Sequence, TakesLineEndsAndBlanksAsTheyCome) {
  const SequenceFolder folder;
  folder.table("#timestamp [ns],filename\r\n100000000 , a.pgm \r\n\r\n200000000,b.pgm");
  EXPECT_EQ(open_sequence(folder.path()).frames.size(), 2U);
}

TEST(Sequence, TakesTheFirstTwoColumns_AndNamesWithDots) {
  const SequenceFolder folder;
  folder.frame("a..pgm", image());
  folder.table("#timestamp [ns],filename,exposure [s]\n100,a..pgm,0.01\n");
  EXPECT_EQ(open_sequence(folder.path()).frames[0].file, "a..pgm");
}

TEST(Sequence, RefusesAPipe_ForItWouldBeWaitedFor) {
  const SequenceFolder folder;
  const std::filesystem::path table = folder.path() / "mav0/cam0/data.csv";
  std::filesystem::remove(table);
  ASSERT_EQ(::mkfifo(table.c_str(), 0600), 0);
  EXPECT_HOLDS(folder.refusal(), "data.csv: not a regular file");
  std::filesystem::remove(table);
  folder.table("100,a.pgm\n");
  std::filesystem::remove(folder.path() / "mav0/cam0/data/a.pgm");
  ASSERT_EQ(::mkfifo((folder.path() / "mav0/cam0/data/a.pgm").c_str(), 0600), 0);
  EXPECT_HOLDS(folder.refusal(), "a.pgm: not a regular file");
}

TEST(Sequence, RefusesTimeStamps_NamingLineAndField) {
  const SequenceFolder folder;
  struct {
    const char* rows;
    const char* says;
  } const cases[] = {
      {"100,a.pgm\n100,b.pgm\n", "data.csv:2: timestamp [ns]: 100 repeats"},
      {"100,a.pgm\n99,b.pgm\n", "data.csv:2: timestamp [ns]: 99 runs back"},
      {"1.5,a.pgm\n", "data.csv:1: timestamp [ns]: '1.5'"},
      {"-5,a.pgm\n", "data.csv:1: timestamp [ns]: '-5'"},
      {"99999999999999999999,a.pgm\n", "data.csv:1: timestamp [ns]"},
      {"100\n", "data.csv:1: '100' is not 'timestamp [ns],filename'"},
      {"100,\n", "data.csv:1: filename: ''"},
      {"100,../../secret.png\n", "data.csv:1: filename"},
      {"#timestamp [ns],filename\n", "data.csv: the sequence has no frames"},
  };
  for (const auto& entry : cases) {
    folder.table(entry.rows);
    EXPECT_HOLDS(folder.refusal(), entry.says);
  }
}

TEST(Sequence, RefusesSensorFiles_NamingFieldAndRange) {
  const SequenceFolder folder;
  struct {
    const char* from;
    const char* to;
    const char* says;
  } const cases[] = {
      {"resolution: [64, 48]", "", "resolution: field is missing"},
      {"[64, 48]", "[64]", "resolution: '[64]', allowed are 2 numbers"},
      {"[64, 48]", "[64, 4]", "resolution[1]: 4 is out of range, allowed 32 .. 8192 px"},
      {"[64, 48]", "[64.5, 48]", "resolution[0]: 64.5 is not a whole number"},
      {"pinhole", "omni", "camera_model: 'omni', allowed is 'pinhole'"},
      {"radial-tangential", "equidistant", "distortion_model: 'equidistant'"},
      {"100.0,", "abc,", "intrinsics: 'abc' is not a number"},
      {"100.0,", ".nan,", "intrinsics[0]"},
      {"100.0,", "-100.0,", "intrinsics[0]: -100.0 is out of range"},
      {"camera_model:", "camera_model: : [", "not YAML"},
      {"camera_model:", "resolution: [32, 32]\ncamera_model:", "resolution: field is there twice"},
      {"sensor_type: camera", "a: &a {b: 1}\n<<: *a", "<<: merge keys are not read"},
  };
  for (const auto& entry : cases) {
    std::string text = kSensor;
    text.replace(text.find(entry.from), std::string(entry.from).size(), entry.to);
    folder.sensor(text);
    EXPECT_HOLDS(folder.refusal(), entry.says);
    EXPECT_HOLDS(folder.refusal(), "sensor.yaml: ");
  }
  std::filesystem::remove(folder.path() / "mav0/cam0/sensor.yaml");
  EXPECT_HOLDS(folder.refusal(), "sensor.yaml: cannot be read: No such file");
  std::filesystem::create_directory(folder.path() / "mav0/cam0/sensor.yaml");
  EXPECT_HOLDS(folder.refusal(), "sensor.yaml: not a regular file");
}

TEST(Sequence, RefusesFoldersThatAreNone) {
  const TemporaryFolder folder;
  const auto refusal = [&](const char* name) {
    return refusal_of<UnusableInput>([&] { (void)open_sequence(folder.path() / name); });
  };
  EXPECT_HOLDS(refusal("absent"), "no such folder");
  EXPECT_HOLDS(refusal("."), "not an image sequence: mav0/cam0/data.csv is missing");
}

TEST(Sequence, TheTablesAreReadWithoutImages_AndIntrinsicsToBeEstimatedWhereTheyAreAllowed) {
  const TemporaryFolder folder;
  folder.write("mav0/cam0/data.csv",
               "# by hand, left\n100000000,a b.png\n# dark, 2 ms\n200000000,\xE9.png,more\n");
  std::string sensor = kSensor;
  sensor.replace(sensor.find("[100"), std::string("[100.0, 101.0, 31.5, 23.5]").size(), "auto");
  folder.write("mav0/cam0/sensor.yaml", sensor + "sigma_focal_px: 0.5\n");
  EXPECT_HOLDS(refusal_of<UnusableInput>([&] { (void)read_tables(folder.path()); }), "'auto'");
  const SequenceTables tables = read_tables(folder.path(), LensNeed::kAny);
  ASSERT_EQ(tables.frames.size(), 2U);
  EXPECT_EQ(tables.frames[0].file, "a b.png");
  EXPECT_EQ(tables.frames[1].file, "\xE9.png");
  EXPECT_FALSE(tables.sensor.intrinsics_known);
  EXPECT_EQ(tables.sensor.camera.fu_px, 64.0);
  EXPECT_EQ(tables.sensor.camera.cv_px, 23.5);
  EXPECT_EQ(tables.sensor.fields.at("sigma_focal_px"), "0.5");
  EXPECT_EQ(tables.sensor.fields.count("resolution"), 0U);
}

TEST(Sequence, ARowTimeUnderAnotherName_AndAReadoutLongerThanAnInterval_AreReported) {
  const SequenceFolder folder;
  struct {
    const char* line;
    const char* says;  ///< nullptr: nothing
  } const cases[] = {
      {"line_time_us: 20", "line_time_us: a rolling shutter"},
      {"Line-Time-ns: 20000", "Line-Time-ns: a rolling shutter"},
      {"line_time: 20000", "line_time: a rolling shutter"},
      {"rolling_shutter_readout_time: 0.03", "rolling_shutter_readout_time: a rolling shutter"},
      {"shutter: Rolling", "shutter: a rolling shutter"},
      {"Shutter_Type: ROLLING_SHUTTER", "Shutter_Type: a rolling shutter"},
      {"line_time_ns: 9000000", "line_time_ns: all rows of a picture take 0.423 s, but"},
      {"line_time_ns: -9000000", "line_time_ns: all rows of a picture take 0.423 s, but"},
      {"line_time_ns: 2000000", nullptr},
      {"shutter: Global\nshutter_speed: 0.001\nline_delay: 0", nullptr},
  };
  for (const auto& entry : cases) {
    folder.sensor(std::string(kSensor) + entry.line + "\n");
    const std::vector<std::string> warnings = read_tables(folder.path()).warnings;
    ASSERT_EQ(warnings.size(), entry.says == nullptr ? 0U : 1U) << entry.line;
    if (entry.says != nullptr) {
      EXPECT_HOLDS(warnings[0], entry.says);
    }
  }
}

TEST(Sequence, ALinkToNothingIsNamed) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("gone", folder.path() / "link");
  EXPECT_HOLDS(refusal_of<UnusableInput>([&] { (void)open_sequence(folder.path() / "link"); }),
               "link: a link to gone, which is not there");
}

TEST(Quote, TextOfJsonNamesOctetsThatAreNotUtf8AsPythonDoes) {
  EXPECT_EQ(json_text("a\"\\\n\xC3\xBC\xE9"), "\"a\\\"\\\\\\u000a\xC3\xBC\\udce9\"");
}

TEST(Sequence, RefusesImagesOfAnotherSize_AndSequencesWithoutAnyImage) {
  const SequenceFolder folder;
  folder.frame("a.pgm",
               "");  // a single bad frame is not the sequence's end: the next one shows the size
  EXPECT_EQ(folder.refusal(), "");
  folder.frame("b.pgm", image(65, 48));
  EXPECT_HOLDS(folder.refusal(),
               "b.pgm: image is 65x48, but sensor.yaml says resolution: [64, 48]");
  for (const char* name : {"a.pgm", "b.pgm", "c.pgm"}) {
    std::filesystem::remove(folder.path() / "mav0/cam0/data" / name);
  }
  EXPECT_HOLDS(folder.refusal(), "none of the 3 images can be read; the first: ");
}

TEST(FileCamera, HandsOverEveryFrame_BadOnesAsNotReadable) {
  const SequenceFolder folder;
  folder.table(
      "100000000,a.pgm\n200000000,missing.pgm\n300000000,big.pgm\n400000000,short.pgm\n"
      "500000000,c.pgm\n");
  folder.frame("big.pgm", image(640, 480));
  folder.frame("short.pgm", image().substr(0, 500));
  const Sequence sequence = open_sequence(folder.path());
  FileCamera camera(sequence);
  Frame frame;
  const char* const reasons[] = {"",
                                 "missing.pgm: cannot be read: No such file",
                                 "big.pgm: image is 640x480",
                                 "short.pgm: PGM: the file ends early",
                                 ""};
  for (std::size_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(camera.next(frame));
    EXPECT_EQ(camera.index(), i);
    EXPECT_EQ(frame.timestamp_ns, static_cast<std::int64_t>(100'000'000 * (i + 1)));
    EXPECT_EQ(frame.readable, camera.refusal().empty());
    EXPECT_EQ(frame.image.data != nullptr, frame.readable);
    EXPECT_HOLDS(camera.refusal(), reasons[i]);
  }
  EXPECT_TRUE(frame.readable);
  EXPECT_FALSE(camera.next(frame));
}

TEST(FileCamera, ImagesOf8BitsAmong16AreReported_AndSayNothingOfTheOthersDepth) {
  const SequenceFolder folder;
  const File rows(std::size_t{kWidth} * kHeight * 2, 9);  // 0x0909: a level of 12 bits
  const File file = encode_png({.width = kWidth, .height = kHeight, .depth = 16}, rows);
  const std::string deep(file.begin(), file.end());
  folder.frame("b.pgm", deep);
  const Sequence sequence = open_sequence(folder.path());
  EXPECT_EQ(sequence.depth_bits, 12);
  FileCamera camera(sequence);
  Frame frame;
  ASSERT_TRUE(camera.next(frame));
  EXPECT_EQ(camera.mixed_remark(), "");
  while (camera.next(frame)) {
  }
  EXPECT_HOLDS(camera.mixed_remark(), "2 pictures have 8 bits a level, 1 have 16");
  EXPECT_HOLDS(camera.mixed_remark(), "differs: b.pgm)");
}

TEST(FileCamera, APgmOfSeveralImagesIsNotReadable_ALineEndBehindItIs) {
  const SequenceFolder folder;
  folder.frame("b.pgm", image() + image());
  folder.frame("c.pgm", image() + "\n");
  const Sequence sequence = open_sequence(folder.path());
  FileCamera camera(sequence);
  Frame frame;
  ASSERT_TRUE(camera.next(frame));
  ASSERT_TRUE(camera.next(frame));
  EXPECT_HOLDS(camera.refusal(), "b.pgm: PGM: several pictures in one file");
  ASSERT_TRUE(camera.next(frame));
  EXPECT_TRUE(frame.readable) << camera.refusal();
}

TEST(FileCamera, AFileThatNoFrameCanNeedIsNotRead) {
  const SequenceFolder folder;
  const std::size_t most = frame_bytes_max({.width_px = kWidth, .height_px = kHeight});
  folder.frame("b.pgm", image() + std::string(most, '\0'));
  const Sequence sequence = open_sequence(folder.path());
  EXPECT_EQ(sequence.file_bytes_max, image().size());
  FileCamera camera(sequence);
  Frame frame;
  ASSERT_TRUE(camera.next(frame));
  EXPECT_TRUE(frame.readable);
  ASSERT_TRUE(camera.next(frame));
  EXPECT_FALSE(frame.readable);
  EXPECT_HOLDS(camera.refusal(), "b.pgm: the file has ");
  ASSERT_TRUE(camera.next(frame));
  EXPECT_TRUE(frame.readable);
}

TEST(FileCamera, AnImageInSeveralScansIsReadOnlyWhereTheFirstIsOne) {
  const SequenceFolder folder;
  const File file =
      encode_jpeg(kWidth, kHeight, File(std::size_t{kWidth} * kHeight, 90), TJFLAG_PROGRESSIVE);
  const std::string scans(file.begin(), file.end());
  folder.frame("b.pgm", scans);  // by content, not by name
  const Sequence without = open_sequence(folder.path());
  FileCamera camera(without);
  Frame frame;
  ASSERT_TRUE(camera.next(frame));
  ASSERT_TRUE(camera.next(frame));
  EXPECT_FALSE(frame.readable);
  EXPECT_HOLDS(camera.refusal(), "b.pgm: JPEG: in several scans");
  folder.frame("a.pgm", scans);
  const Sequence with = open_sequence(folder.path());
  FileCamera planned(with);
  ASSERT_TRUE(planned.next(frame));
  ASSERT_TRUE(planned.next(frame));
  EXPECT_TRUE(frame.readable) << planned.refusal();
}

TEST(FileCamera, KeepsItsBuffer) {
  const SequenceFolder folder;
  const Sequence sequence = open_sequence(folder.path());
  FileCamera camera(sequence);
  Frame frame;
  ASSERT_TRUE(camera.next(frame));
  const std::uint8_t* before = frame.image.data;
  ASSERT_TRUE(camera.next(frame));
  EXPECT_EQ(frame.image.data, before);
}

}  // namespace
}  // namespace polhode::platform::sequence_test
