#include "app/places.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "../transport/small_files.hpp"
#include "errors.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::places_test {
namespace {

namespace fs = std::filesystem;

class Places : public testing::Test {
 protected:
  template <typename Problem = UnusableInput>
  [[nodiscard]] std::string refusal() const {
    return refusal_of<Problem>([&] { (void)prepare_places("live.toml", machine_); });
  }
  [[nodiscard]] std::string place(const char* name) const { return folder_.path() / name; }

  TemporaryFolder folder_;
  MachineOptions machine_;
};

TEST_F(Places, FoldersThatAreMissingAreMade) {
  machine_.run.folder = place("a/run");
  machine_.run.checkpoint = place("b/state/checkpoint");
  machine_.recording.folder = place("c/recording");
  EXPECT_EQ(refusal(), "");
  EXPECT_TRUE(fs::is_directory(machine_.run.folder));
  EXPECT_TRUE(fs::is_directory(machine_.recording.folder));
  EXPECT_TRUE(fs::is_directory(place("b/state")));
  EXPECT_FALSE(fs::exists(machine_.run.checkpoint));
}

TEST_F(Places, NothingIsWritten_NothingIsAsked) { EXPECT_EQ(refusal(), ""); }

TEST_F(Places, WhatIsNoPlaceIsRefusedByItsKey) {
  std::ofstream(place("file")) << "mine";
  machine_.run.folder = place("file");
  EXPECT_EQ(refusal().rfind("live.toml: run.folder: ", 0), 0U) << refusal();
  machine_.run.folder.clear();
  machine_.recording.folder = place("file/below");
  EXPECT_NE(refusal().find("recording.folder: "), std::string::npos) << refusal();
  machine_.recording.folder.clear();
  machine_.run.checkpoint = place("file/checkpoint");
  EXPECT_NE(refusal().find("run.checkpoint: "), std::string::npos) << refusal();
}

TEST_F(Places, ACheckOfThemMakesNothing_AndRefusesWhatIsInTheWay) {
  machine_.run.folder = place("a/run");
  machine_.run.checkpoint = place("b/checkpoint");
  machine_.recording.folder = place("c");
  check_places("live.toml", machine_);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  const auto refused = [this] {
    return refusal_of<UnusableInput>([this] { check_places("live.toml", machine_); });
  };
  fs::create_directories(machine_.run.checkpoint);
  EXPECT_NE(refused().find("run.checkpoint: "), std::string::npos) << refused();
  std::ofstream(machine_.recording.folder) << "mine";
  EXPECT_NE(refused().find("recording.folder: "), std::string::npos) << refused();
}

TEST_F(Places, ARunJsonOfOthersIsRefused_ThatOfARunIsNot) {
  machine_.run.folder = folder_.path();
  std::ofstream(place("run.json")) << R"({"experiment": 7})";
  EXPECT_NE(refusal().find("run.folder: "), std::string::npos) << refusal();
  EXPECT_NE(refusal().find("holds a run.json that no run wrote"), std::string::npos) << refusal();
  fs::rename(place("run.json"), place("precious"));
  fs::create_symlink(place("precious"), place("run.json"));
  EXPECT_EQ(refusal(), "") << "a link is replaced, what it names is left";
  fs::remove(place("run.json"));
  std::ofstream(place("run.json")) << R"({"config_hash": "", "frames_accepted": 0})";
  EXPECT_EQ(refusal(), "");
}

TEST_F(Places, EachIsOfOneRun) {
  const auto taken = [](const std::string& path) {
    return path + ": process " + std::to_string(::getpid()) + " has it";
  };
  machine_.run.folder = place("run");
  machine_.recording.folder = place("run/.");  // the same by another name is no second run
  machine_.run.checkpoint = place("state/checkpoint");
  const std::vector<Descriptor> locks = prepare_places("live.toml", machine_);
  MachineOptions& other = machine_;
  other.recording.folder.clear();
  other.run.checkpoint.clear();
  EXPECT_EQ(refusal<RunFailure>(), "live.toml: run.folder: " + taken(place("run")));
  std::swap(other.run.folder, other.recording.folder);
  EXPECT_EQ(refusal<RunFailure>(), "live.toml: recording.folder: " + taken(place("run")));
  other.recording.folder.clear();
  other.run.checkpoint = place("state/checkpoint");
  EXPECT_EQ(refusal<RunFailure>(),
            "live.toml: run.checkpoint: " + taken(place("state/checkpoint")));
  other.run.checkpoint = place("state/other");
  EXPECT_EQ(refusal(), "");
}

TEST_F(Places, AreFreeAgainWhenTheRunIsOver) {
  machine_.run.folder = place("run");
  machine_.run.checkpoint = place("checkpoint");
  EXPECT_EQ(refusal(), "");
  EXPECT_EQ(refusal(), "");
}

/// As a run by hand as root leaves them to a service that runs as a user of its own.
TEST_F(Places, ALockThatRootLeftBehindIsNamedWithItsOwner) {
  if (::geteuid() != 0) {
    GTEST_SKIP() << "only root can leave a file to another user";
  }
  constexpr uid_t kService = 65534;
  machine_.run.checkpoint = place("checkpoint");
  EXPECT_EQ(refusal(), "");
  fs::permissions(folder_.path(), fs::perms::all);
  ASSERT_EQ(::seteuid(kService), 0);
  const std::string refused = refusal();
  ASSERT_EQ(::seteuid(0), 0);
  EXPECT_EQ(
      refused,
      "live.toml: run.checkpoint: " + place("checkpoint.lock") +
          ": cannot be made: belongs to user 0, not to 65534; give it to that user, or remove it");
}

TEST_F(Places, WithoutAFreeDescriptorAreNoFaultOfTheSettings) {
  machine_.run.folder = place("run");
  const FewFiles none(0);
  EXPECT_EQ(refusal<RunFailure>(),
            "live.toml: run.folder: " + place("run") + ": cannot be opened: Too many open files");
}

TEST_F(Places, AFolderInPlaceOfTheCheckpointIsRefused) {
  machine_.run.checkpoint = folder_.path();
  EXPECT_NE(refusal().find("is a folder"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace polhode::platform::places_test
