#include "app/output_folder.hpp"

#include <gtest/gtest.h>

#include "errors.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::output_folder_test {
namespace {

namespace fs = std::filesystem;

template <typename Problem = UnusableInput>
std::string refusal(const fs::path& folder) {
  return refusal_of<Problem>([&] { (void)prepare_output_folder(folder); });
}

TEST(OutputFolder, IsCreatedWithItsParents) {
  const TemporaryFolder folder;
  (void)prepare_output_folder(folder.path() / "a/b");
  EXPECT_TRUE(fs::is_directory(folder.path() / "a/b"));
}

TEST(OutputFolder, OfAnEarlierRun_LosesThatRunsFilesOnly) {
  const TemporaryFolder folder;
  (void)prepare_output_folder(folder.path());
  folder.write("motion.csv", "old");
  folder.write("notes.txt", "mine");
  folder.write("plots/rates.png", "picture");
  (void)prepare_output_folder(folder.path());
  EXPECT_FALSE(fs::exists(folder.path() / "motion.csv"));
  EXPECT_TRUE(fs::exists(folder.path() / "notes.txt"));
  EXPECT_TRUE(fs::exists(folder.path() / "plots/rates.png"));
}

// verifies: PRG-04
TEST(OutputFolder, OfSomebodyElse_IsRefusedAndKept) {
  const TemporaryFolder folder;
  folder.write("motion.csv", "somebody's");
  EXPECT_NE(refusal(folder.path()).find("holds files that no replay wrote"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder.path() / "motion.csv"));
}

TEST(OutputFolder, OfAReplayThatRuns_IsRefusedAndKept) {
  const TemporaryFolder folder;
  {
    const Descriptor lock = prepare_output_folder(folder.path());
    folder.write("motion.csv", "new");
    EXPECT_EQ(
        refusal<RunFailure>(folder.path()),
        "--out " + folder.path().string() + ": process " + std::to_string(::getpid()) + " has it");
    EXPECT_TRUE(fs::exists(folder.path() / "motion.csv"));
  }
  EXPECT_EQ(refusal(folder.path()), "");
}

TEST(OutputFolder, ThatIsAFile_IsRefused) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("file", "");
  EXPECT_NE(refusal(file).find("is not a folder"), std::string::npos);
  EXPECT_NE(refusal(file / "below").find("cannot be created"), std::string::npos);
}

}  // namespace
}  // namespace polhode::platform::output_folder_test
