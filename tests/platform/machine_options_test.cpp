#include "parameters/machine_options.hpp"

#include <gtest/gtest.h>

#include "errors.hpp"
#include "parameters/load.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::machine_options_test {
namespace {

using Settings = std::vector<std::string>;

MachineOptions load(std::string_view text, const Settings& settings = {}) {
  const TemporaryFolder folder;
  return load_machine_options(folder.write("live.toml", text), settings);
}

std::string refusal(std::string_view text, const Settings& settings = {}) {
  return refusal_of<UnusableInput>([&] { (void)load(text, settings); });
}

#define EXPECT_HOLDS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(MachineOptions, AreReadBesideTheEstimatorsOwn) {
  const TemporaryFolder folder;
  const auto file = folder.write("live.toml",
                                 "seed = 7\n[device]\nsource = \"/dev/video3\"\nrate_hz = 25\n"
                                 "[run]\ncheckpoint_frames = 9\n[recording]\ncomplete = true\n");
  const Settings settings{"device.buffers=8", "features.count_max=300"};
  const MachineOptions machine = load_machine_options(file, settings);
  EXPECT_EQ(machine.device.source, "/dev/video3");
  EXPECT_EQ(machine.device.rate_hz, 25.0);
  EXPECT_EQ(machine.device.buffers, 8);
  EXPECT_EQ(machine.run.checkpoint_frames, 9);
  EXPECT_TRUE(machine.recording.complete);
  const Configuration configuration = load_configuration(file, settings);
  EXPECT_EQ(configuration.parameters.seed, 7U);
  EXPECT_EQ(configuration.parameters.features.count_max, 300);
}

TEST(MachineOptions, RefuseWhatIsUnknownOrOutOfRange_NamingPlaceKeyAndRange) {
  EXPECT_HOLDS(refusal("[device]\nsorce = \"x\"\n"), ":2: device.sorce: unknown key");
  EXPECT_HOLDS(refusal("[device]\nbuffers = 1\n"),
               "device.buffers = 1: allowed is a whole number 2 .. 32");
  EXPECT_HOLDS(refusal("[device]\nbuffers = 2.5\n"), "a whole number");
  EXPECT_HOLDS(refusal("[device]\nsource = 3\n"), "a text");
  EXPECT_HOLDS(refusal("[device]\ngain = nan\n"), "-1 .. 1");
  EXPECT_HOLDS(refusal("", {"recording.complete=1"}), "true or false");
  EXPECT_HOLDS(refusal("[device]\npixel_format = \"H264\"\n"), "\"GREY\"");
  EXPECT_HOLDS(refusal("[device]\nclock = \"tai\"\n"), "\"utc\"");
  EXPECT_HOLDS(refusal("[device]\nrate_hz = 0.1\n"),
               "a frame comes every 10000 ms; allowed is twice that");
}

TEST(MachineOptions, AreAllInTheExample) {
  const std::filesystem::path example = POLHODE_REPOSITORY "/config/live.toml";
  const MachineOptions machine = load_machine_options(example, {});
  EXPECT_EQ(machine.device.source, "/dev/video0");
  EXPECT_EQ(load_configuration(example, {}).parameters.camera.width_px, 1920);
  std::ifstream in(example);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const std::string& key : machine_keys()) {
    EXPECT_HOLDS(text, "\n" + key.substr(key.find('.') + 1) + " = ");
  }
}

}  // namespace
}  // namespace polhode::platform::machine_options_test
