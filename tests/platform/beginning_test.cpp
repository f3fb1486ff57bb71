// Where a run begins, and what a crash on the way there leaves.
#include "app/beginning.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdlib>

#include "../pipeline/bench.hpp"
#include "app/checkpoint_writer.hpp"
#include "os/linux/memory/table_memory.hpp"
#include "pipeline/checkpoint.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::beginning_test {
namespace {

namespace fs = std::filesystem;

class BeginningTest : public testing::Test {
 protected:
  BeginningTest() {
    machine_.run.checkpoint = folder_.path() / "checkpoint";
    Result<Component*> made = Component::create(memory_.span(), bench::parameters());
    component_ = made.value();
    write();
  }

  /// The component's state as the last checkpoint.
  void write() const {
    std::vector<std::uint8_t> content(checkpoint_octets_max());
    content.resize(save_checkpoint(*component_, content));
    const CheckpointStamp stamp{.identity = Beginning(machine_, hash_).identity(),
                                .boot_id = this_boot(),
                                .stepped = moment_now()};
    EXPECT_TRUE(write_checkpoint_file(CheckpointPlaces(machine_.run.checkpoint), stamp, content));
  }

  /// In a process of its own. @return its exit status, or the signal's number + 128.
  template <typename Prepare>
  int begin(Prepare prepare) {
    const pid_t child = ::fork();
    if (child == 0) {
      int status = 0;
      try {
        prepare();
        Beginning beginning(machine_, hash_);
        beginning.restore(*component_);
      } catch (...) {
        status = 1;
      }
      std::_Exit(status);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }
  [[nodiscard]] CrashMark mark() const {
    return read_crash_mark(crash_mark_file(machine_.run.checkpoint));
  }
  /// Of the checkpoint on the disk.
  [[nodiscard]] std::uint32_t checksum() const {
    return load_whole_checkpoint(machine_.run.checkpoint, this_build()).checksum;
  }
  /// Writing to the tables is a fault.
  void forbid_writing() { ::mprotect(memory_.span().data(), memory_.span().size(), PROT_READ); }

  TemporaryFolder folder_;
  MachineOptions machine_;
  std::string hash_ = std::string(64, 'a');
  TableMemory memory_{memory_needed(bench::parameters()).total};
  Component* component_ = nullptr;
};

TEST_F(BeginningTest, WithoutACrashItIsWarm_AndLeavesNoMark) {
  Beginning beginning(machine_, hash_);
  beginning.restore(*component_);
  EXPECT_EQ(beginning.how().substr(0, 5), "warm:");
  EXPECT_NE(beginning.watch(), nullptr);
  EXPECT_EQ(mark().crashes, 0U);
}

TEST_F(BeginningTest, AFileThatNoRunLeftIsKeptUnderAFreeName) {
  const std::string mine = machine_.run.checkpoint;
  const std::string theirs = "notes of somebody's";
  folder_.write("checkpoint", theirs);
  folder_.write("checkpoint.found", "an earlier one");
  Beginning beginning(machine_, hash_);
  beginning.restore(*component_);
  EXPECT_FALSE(fs::exists(mine));
  EXPECT_EQ(fs::file_size(mine + ".found2"), theirs.size());
  EXPECT_NE(beginning.how().find("kept as " + mine + ".found2"), std::string::npos)
      << beginning.how();
}

TEST_F(BeginningTest, ACrashWhileACheckpointIsRestoredIsLaidToIt) {
  EXPECT_EQ(begin([this] { forbid_writing(); }), 128 + SIGSEGV);
  EXPECT_EQ(mark().crashes, 1U);
  EXPECT_TRUE(mark().was_tried(checksum()));
  Beginning next(machine_, hash_);
  next.restore(*component_);
  EXPECT_EQ(next.how(), "cold: the checkpoint is not used: a run that began from it crashed");
}

TEST_F(BeginningTest, SoIsAnEndByAnException) {
  const auto no_more_memory = [] {
    const rlimit none{.rlim_cur = 0, .rlim_max = 0};  // to what there is: nothing is mapped again
    ::setrlimit(RLIMIT_AS, &none);
  };
  EXPECT_EQ(begin(no_more_memory), 1);
  EXPECT_EQ(mark().crashes, 1U);
}

/// Two generations, as the unit starts them one after the other; then none is read any more.
TEST_F(BeginningTest, TwoGenerationsThatCrashOnTheWayAreFollowedByACold) {
  const CheckpointPlaces places(machine_.run.checkpoint);
  EXPECT_EQ(begin([this] { forbid_writing(); }), 128 + SIGSEGV);
  write();  // by a run between: the first becomes the one before
  EXPECT_EQ(begin([this] { forbid_writing(); }), 128 + SIGSEGV);
  EXPECT_EQ(mark().crashes, 2U);
  EXPECT_EQ(begin([this] { forbid_writing(); }), 0);
  EXPECT_FALSE(fs::exists(places.file) || fs::exists(places.before));
}

}  // namespace
}  // namespace polhode::platform::beginning_test
