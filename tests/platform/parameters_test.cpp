#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "config/limits.hpp"
#include "errors.hpp"
#include "parameters/load.hpp"
#include "parameters/print.hpp"
#include "parameters/sha256.hpp"
#include "parameters/suggest.hpp"
#include "pipeline/parameter_table.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::parameters_test {
namespace {

using Settings = std::vector<std::string>;

CameraParameters good_camera() {
  return {.width_px = 640,
          .height_px = 480,
          .fu_px = 900.0,
          .fv_px = 900.0,
          .cu_px = 320.0,
          .cv_px = 240.0};
}

Configuration load(std::string_view text, const Settings& settings = {}) {
  const TemporaryFolder folder;
  const std::string_view some = text.empty() ? "seed = 1\n" : text;
  return load_configuration(folder.write("own.toml", some), settings);
}

std::string refusal(std::string_view text, const Settings& settings = {}) {
  return refusal_of<UnusableInput>([&] { (void)load(text, settings); });
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

#define EXPECT_HOLDS(text, part) EXPECT_TRUE(holds(text, part)) << text

TEST(Parameters, DefaultsAreInRange) {
  Parameters parameters;
  EXPECT_FALSE(check_without_camera(parameters));
  EXPECT_TRUE(check(parameters));  // there is no default camera
  parameters.camera = good_camera();
  EXPECT_FALSE(check(parameters));
}

// verifies: CMP-03
TEST(Parameters, EveryRowRefusesWhatIsBeyondItsEnds_NamingKeyAndRange) {
  for (const ParameterRow& row : parameter_table()) {
    const auto* real = std::get_if<Member<double>>(&row.member);
    if (real == nullptr) {
      continue;
    }
    const double above = std::nextafter(row.high, std::numeric_limits<double>::infinity());
    const double below = std::nextafter(row.low, -std::numeric_limits<double>::infinity());
    for (const double value : {above, below, std::numeric_limits<double>::quiet_NaN()}) {
      Parameters parameters;
      (*real)(parameters) = value;
      const auto problem = check_row(row, parameters);
      ASSERT_TRUE(problem) << row.key;
      EXPECT_EQ(problem->code, ErrorCode::kBadParameter);
      EXPECT_HOLDS(problem->message, std::string(row.key));
      EXPECT_HOLDS(problem->message, "allowed " + range_text(row));
    }
    Parameters parameters;
    (*real)(parameters) = row.low;
    EXPECT_FALSE(check_row(row, parameters)) << row.key;
    (*real)(parameters) = row.high;
    EXPECT_FALSE(check_row(row, parameters)) << row.key;
  }
}

/// As a checkpoint may hold them that somebody has altered.
TEST(Parameters, AWordThatIsNoneIsRefusedByItsNumber) {
  for (const ParameterRow& row : parameter_table()) {
    Parameters parameters;
    parameters.motion.mode = static_cast<MotionMode>(200);
    if (row.key == "motion.mode") {
      const auto problem = check_row(row, parameters);
      ASSERT_TRUE(problem);
      EXPECT_HOLDS(problem->message, "motion.mode = 200: out of range");
    }
  }
}

TEST(Parameters, AnImageIsAsLargeAsTheTablesAtMost) {
  Parameters parameters;
  parameters.camera = good_camera();
  parameters.camera.width_px = static_cast<int>(limits::kImageSide);
  EXPECT_FALSE(check(parameters));
  parameters.camera.width_px += 1;
  EXPECT_TRUE(check(parameters));
}

TEST(Parameters, CheckTiesTheTwoGapsOfTheStartTogether) {
  Parameters parameters;
  parameters.start.chi2_gap_commit = 10.0;
  parameters.start.chi2_gap_convexity = 12.0;
  ASSERT_TRUE(check_without_camera(parameters));
  EXPECT_HOLDS(check_without_camera(parameters)->message, "start.chi2_gap_convexity = 12.0");
}

TEST(Parameters, CheckLooksAtTheScaleThatIsChosen) {
  Parameters parameters;
  parameters.camera = good_camera();
  parameters.scale.range_m = -1.0;
  EXPECT_HOLDS(check(parameters)->message, "scale.range_m = -1.0: out of range");
  parameters.scale.range_m = 10.0;
  EXPECT_FALSE(check(parameters));
  parameters.scale.range_sigma_m = -0.1;
  EXPECT_HOLDS(check(parameters)->message, "scale.range_sigma_m = -0.1: out of range");
  parameters.scale = {.known_diameter_m = 5000.0};
  EXPECT_HOLDS(check(parameters)->message, "scale.known_diameter_m = 5000.0: out of range");
  parameters.scale = {.known_edge_m = std::nan("")};
  EXPECT_HOLDS(check(parameters)->message, "scale.known_edge_m = nan: out of range");
  parameters.scale = {.known_length_m = 0.5};
  EXPECT_HOLDS(check(parameters)->message, "the two ends coincide");
  parameters.scale.points_px = {{{10.0, 20.0}, {700.0, 30.0}}};
  EXPECT_HOLDS(check(parameters)->message, "outside the image");
  parameters.scale.points_px[1][0] = 600.0;
  EXPECT_FALSE(check(parameters));
}

TEST(Configuration, FileAndSettingsChangeDefaults_LaterWins) {
  const Configuration loaded =
      load("seed = 7\n[features]\ncount_max = 300\ncontrast_min = 0.02\n[mask]\nenabled = false\n",
           {"features.count_max=400", "features.count_max=500", "features.contrast_min=0.03"});
  EXPECT_EQ(loaded.parameters.seed, 7U);
  EXPECT_EQ(loaded.parameters.features.count_max, 500);
  EXPECT_EQ(loaded.parameters.features.contrast_min, 0.03);
  EXPECT_FALSE(loaded.parameters.mask.enabled);
  EXPECT_EQ(loaded.parameters.map.keyframes_max, Parameters{}.map.keyframes_max);
}

// verifies: PRG-01
TEST(Configuration, RefusalsNameFileLineKeyValueAndRange) {
  struct {
    const char* text;
    const char* says;
  } const cases[] = {
      {"[features]\ncount_max = 5000\n",
       "own.toml:2: features.count_max = 5000: out of range, allowed 50 .. 1000"},
      {"[features]\ncount_max = 99999999999\n",
       "own.toml:2: features.count_max = 99999999999: wrong type"},
      {"[features]\ncount_max = \"many\"\n",
       "own.toml:2: features.count_max = 'many': wrong type, allowed is a whole number"},
      {"[features]\ncount_max = 300.0\n", "wrong type, allowed is a whole number in 50 .. 1000"},
      {"[features]\ncontrast_min = nan\n", "own.toml:2: features.contrast_min = nan: out of range"},
      {"[mask]\nenabled = 1\n", "mask.enabled = 1: wrong type, allowed is true or false"},
      {"seed = -1\n", "own.toml:1: seed = -1: wrong type, allowed is a whole number, 0 or more"},
      {"[features]\ncount_mx = 300\n",
       "own.toml:2: features.count_mx: unknown key; did you mean features.count_max?"},
      {"count_max = 300\n", "own.toml:1: count_max: unknown key; did you mean features.count_max?"},
      {"[weather]\nrain = 1\n",
       "own.toml:2: weather.rain: unknown key; `polhode check --defaults`"},
      {"[weather]\n", "own.toml:1: weather: unknown key"},
      {"features = 3\n", "own.toml:1: features: unknown key"},
      {"[features]\ncount_max = {a = 1}\n", "wrong type"},
      {"[features\n", "own.toml:1: "},
      {"[scale]\nknown_length_m = 0.5\n",
       "scale.points_px is missing, it goes with scale.known_length_m"},
      {"[scale]\nrange_m = 5\n", "scale.frame_timestamp_ns is missing, it goes with scale.range_m"},
      {"[scale]\nframe_timestamp_ns = 5\n", "scale.known_length_m is missing"},
      {"[scale]\npoints_px = [[1.0, 2.0]]\n", "wrong type, allowed is two points [[u, v], [u, v]]"},
      {"[scale]\npoints_px = [[1.0, 2.0], [3.0, \"4\"]]\n", "allowed is two points"},
      {"[scale]\nrange_m = 5\nknown_length_m = 1\nframe_timestamp_ns = 1\n",
       "scale.points_px is missing"},
      {"[scale]\nrange_sigma_m = 5\n", "scale.range_m is missing"},
      {"[start]\nchi2_gap_commit = 10\n",
       "start.chi2_gap_convexity = 18.0: out of range, allowed 4.0 .. 10.0"},
      {"[camera]\nwidth_px = 640\n", "camera.height_px = 0: out of range, allowed 32 .. 8192"},
  };
  for (const auto& entry : cases) {
    EXPECT_HOLDS(refusal(entry.text), entry.says);
  }
}

TEST(Configuration, SettingsAreCheckedLikeTheFile) {
  EXPECT_HOLDS(refusal("", {"features.count_max=5000"}),
               "--set features.count_max=5000: features.count_max = 5000: out of range");
  EXPECT_HOLDS(refusal("", {"features.count_max"}), "allowed is key=value");
  EXPECT_HOLDS(refusal("", {"features.count_max=\n"}), "allowed is key=value");
  EXPECT_HOLDS(refusal("", {"features.count_max=soon"}), "--set features.count_max=soon: ");
  EXPECT_HOLDS(refusal("", {"=3"}), "--set =3: ");
}

TEST(Configuration, AFileThatIsNotThereIsRefused) {
  const auto call = [] { (void)load_configuration("/nowhere/own.toml", {}); };
  EXPECT_HOLDS(refusal_of<UnusableInput>(call), "/nowhere/own.toml: cannot be read: No such file");
}

TEST(Configuration, WhatIsNoRegularFileIsRefused) {
  const TemporaryFolder folder;
  for (const std::filesystem::path& path : {folder.path(), std::filesystem::path("/dev/null")}) {
    EXPECT_EQ(refusal_of<UnusableInput>([&] { (void)load_configuration(path, {}); }),
              path.string() + ": not a regular file");
  }
}

TEST(Configuration, AnEmptyFileIsReportedAsEmpty) {
  const TemporaryFolder folder;
  for (const char* text : {"", "\n\n", "# seed = 1\n"}) {
    const std::filesystem::path file = folder.write("own.toml", text);
    EXPECT_EQ(refusal_of<UnusableInput>([&] { (void)load_configuration(file, {}); }),
              file.string() + ": is empty: it sets nothing");
  }
}

TEST(Configuration, AKnownLengthChoosesTheScale) {
  const Configuration loaded = load("",
                                    {"scale.known_length_m=0.6",
                                     "scale.points_px=[[812.0,400.5],[1010.2,377.9]]",
                                     "scale.frame_timestamp_ns=1700000000000000000"});
  EXPECT_EQ(loaded.parameters.scale.known_length_m, 0.6);
  EXPECT_EQ(loaded.parameters.scale.points_px[1][0], 1010.2);
  EXPECT_EQ(loaded.parameters.scale.frame_timestamp_ns, 1700000000000000000);
}

TEST(Configuration, DocumentedDefaultsAreTheDefaults) {
  const Configuration loaded = load(documented_defaults());
  EXPECT_EQ(canonical_text(loaded.parameters), canonical_text(Parameters{}));
  for (const ParameterRow& row : parameter_table()) {
    EXPECT_HOLDS(documented_defaults(), std::string(row.key.substr(row.key.find('.') + 1)) + " = ");
  }
}

TEST(Configuration, HashDependsOnValues_NotOnHowTheyWereGiven) {
  const auto hash = [](const Configuration& c) { return sha256_of(canonical_text(c.parameters)); };
  EXPECT_EQ(hash(load("[features]\ncount_max = 300\n")),
            hash(load("# text\nseed = 1\n", {"features.count_max=300"})));
  EXPECT_EQ(hash(load("[tracks]\nsmall_motion_max_px = 24\n")), hash(load("")));
  EXPECT_NE(hash(load("[features]\ncount_max = 300\n")), hash(load("")));
}

TEST(Configuration, ValuesReadBackFromTheirText) {
  Parameters parameters;
  parameters.features.contrast_min = 0.1 + 0.2 * 1e-9;
  parameters.tracks.small_motion_max_px = 100.0;
  const Configuration loaded = load(
      "",
      {"features.contrast_min=" + value_text(*find_parameter("features.contrast_min"), parameters),
       "tracks.small_motion_max_px=" +
           value_text(*find_parameter("tracks.small_motion_max_px"), parameters)});
  EXPECT_EQ(loaded.parameters.features.contrast_min, parameters.features.contrast_min);
  EXPECT_EQ(loaded.parameters.tracks.small_motion_max_px, 100.0);
}

TEST(Suggest, FindsTheNearestKey) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(nearest_parameter("feature.count_max"), "features.count_max");
  EXPECT_EQ(nearest_parameter("keyframes_max"), "map.keyframes_max");
  EXPECT_EQ(nearest_parameter("completely.different_thing"), "");
}

TEST(Sha256, GivesTheStandardsValue) {
  // FIPS 180-2, appendix B.1
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace polhode::platform::parameters_test
