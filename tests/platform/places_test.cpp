#include "app/places.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "errors.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

class Places : public testing::Test {
 protected:
  [[nodiscard]] std::string refusal() const {
    try {
      (void)prepare_places("live.toml", machine_);
    } catch (const UnusableInput& problem) {
      return problem.what();
    }
    return {};
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
  EXPECT_EQ(refusal(), "live.toml: run.folder: " + taken(place("run")));
  std::swap(other.run.folder, other.recording.folder);
  EXPECT_EQ(refusal(), "live.toml: recording.folder: " + taken(place("run")));
  other.recording.folder.clear();
  other.run.checkpoint = place("state/checkpoint");
  EXPECT_EQ(refusal(), "live.toml: run.checkpoint: " + taken(place("state/checkpoint")));
  other.run.checkpoint = place("state/other");
  EXPECT_EQ(refusal(), "");
}

TEST_F(Places, AreFreeAgainWhenTheRunIsOver) {
  machine_.run.folder = place("run");
  machine_.run.checkpoint = place("checkpoint");
  EXPECT_EQ(refusal(), "");
  EXPECT_EQ(refusal(), "");
}

TEST_F(Places, AFolderInPlaceOfTheCheckpointIsRefused) {
  machine_.run.checkpoint = folder_.path();
  EXPECT_NE(refusal().find("is a folder"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace polhode::platform
