#include "app/checkpoint_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "temporary_folder.hpp"

namespace polhode::platform::checkpoint_file_test {
namespace {

namespace fs = std::filesystem;

CheckpointIdentity identity(char config, char boot) {
  CheckpointIdentity made;
  made.config_hash.fill(config);
  made.boot_id.fill(boot);
  return made;
}

class CheckpointFile : public testing::Test {
 protected:
  bool write(std::span<const std::uint8_t> content) {
    return write_checkpoint_file(
        places_,
        {.identity = identity('a', 'b'), .utc_ns = 1'000'000'000'000, .restarts = 3},
        content);
  }
  [[nodiscard]] LoadedCheckpoint load(const CheckpointIdentity& who = identity('a', 'b'),
                                      std::int64_t utc_ns = 1'005'000'000'000) const {
    return load_checkpoint_file(file_, who, utc_ns, 60.0);
  }
  static std::vector<std::uint8_t> content_of(const LoadedCheckpoint& loaded) {
    return {loaded.content.begin(), loaded.content.end()};
  }
  [[nodiscard]] std::string octets() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void replace(const std::string& octets) const {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << octets;
  }

  TemporaryFolder folder_;
  fs::path file_ = folder_.path() / "checkpoint";
  fs::path beside_ = folder_.path() / "checkpoint.new";
  CheckpointPlaces places_{file_};
  std::vector<std::uint8_t> content_{1, 2, 3, 4, 5, 6, 7};
};

TEST_F(CheckpointFile, ComesBackAsItWas) {
  ASSERT_TRUE(write(content_));
  const LoadedCheckpoint loaded = load();
  EXPECT_EQ(loaded.refusal, "");
  EXPECT_EQ(content_of(loaded), content_);
  EXPECT_DOUBLE_EQ(loaded.age_s, 5.0);
  EXPECT_EQ(loaded.restarts, 3U);
  EXPECT_FALSE(fs::exists(beside_));
}

// verifies: LIV-04
TEST_F(CheckpointFile, CutOffAnywhereItIsRefused) {
  ASSERT_TRUE(write(content_));
  const std::string good = octets();
  for (std::size_t length = 0; length < good.size(); ++length) {
    replace(good.substr(0, length));
    EXPECT_NE(load().refusal, "") << length;
    EXPECT_TRUE(load().content.empty()) << length;
  }
  replace(good + "x");
  EXPECT_NE(load().refusal, "");
}

// verifies: LIV-04
TEST_F(CheckpointFile, WithAnyBitFlippedItIsRefused) {
  ASSERT_TRUE(write(content_));
  const std::string good = octets();
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string damaged = good;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    replace(damaged);
    EXPECT_NE(load().refusal, "") << bit;
  }
}

// verifies: LIV-04
TEST_F(CheckpointFile, OfAnotherConfigurationBootOrTimeItIsRefused) {
  ASSERT_TRUE(write(content_));
  EXPECT_EQ(load(identity('x', 'b')).refusal, "of another configuration");
  EXPECT_EQ(load(identity('a', 'x')).refusal, "from before the machine was started");
  EXPECT_NE(load(identity('a', 'b'), 1'061'000'000'000).refusal, "");  // 61 s old
  EXPECT_NE(load(identity('a', 'b'), 999'000'000'000).refusal, "");    // from the future
}

// verifies: LIV-04
TEST_F(CheckpointFile, OfAnotherBuildItIsRefusedEverywhere) {
  CheckpointIdentity other = identity('a', 'b');
  other.build_id[7] = 1;
  ASSERT_TRUE(write(content_));
  EXPECT_EQ(load(other).refusal, "of another build");
  EXPECT_EQ(load_whole_checkpoint(file_, other.build_id).refusal, "of another build");
  EXPECT_EQ(content_of(load_whole_checkpoint(file_, identity('x', 'y').build_id)), content_);
}

TEST_F(CheckpointFile, TheOneBeforeTheLastStaysBesideIt) {
  ASSERT_TRUE(write(content_));
  const std::string first = octets();
  ASSERT_TRUE(write(std::vector<std::uint8_t>{8, 9}));
  std::ifstream before(checkpoint_before(file_), std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(before), {}), first);
}

TEST_F(CheckpointFile, ThatIsNotThereIsRefused) { EXPECT_NE(load().refusal, ""); }

TEST_F(CheckpointFile, AFailedWriteLeavesTheOldOne) {
  ASSERT_TRUE(write(content_));
  CheckpointPlaces full = places_;
  full.beside = folder_.path() / "absent/new";
  EXPECT_FALSE(
      write_checkpoint_file(full, {.identity = identity('a', 'b')}, std::vector<std::uint8_t>{9}));
  EXPECT_EQ(content_of(load()), content_);
  // A half-written one beside it, as an end in the middle of writing leaves it, changes nothing.
  std::ofstream(beside_) << "half";
  EXPECT_EQ(content_of(load()), content_);
  ASSERT_TRUE(write({}));
  EXPECT_EQ(load().refusal, "");
}

TEST_F(CheckpointFile, ThatOthersMayHaveWrittenStartsNoRun) {
  ASSERT_TRUE(write(content_));
  ASSERT_EQ(::chmod(file_.c_str(), 0660), 0);
  EXPECT_EQ(load().refusal, "is open to others: mode 0660");
  ASSERT_EQ(::chmod(file_.c_str(), 0640), 0);
  EXPECT_EQ(load().refusal, "");
  if (::geteuid() == 0) {
    ASSERT_EQ(::chown(file_.c_str(), 65534, 65534), 0);
    EXPECT_EQ(load().refusal, "belongs to user 65534, not to 0");
    EXPECT_TRUE(load().octets.empty());
    EXPECT_EQ(load_whole_checkpoint(file_, BuildId{}).refusal, "") << "a replay was told which";
  }
}

}  // namespace
}  // namespace polhode::platform::checkpoint_file_test
