#include "app/checkpoint_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iterator>

#include "base/crc.hpp"
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
  bool write(std::span<const std::uint8_t> content, const polhode_key* key = nullptr) {
    return write_checkpoint_file(
        places_,
        {.identity = identity('a', 'b'), .boot_id = boot_, .stepped = kStepped, .restarts = 3},
        content,
        key);
  }
  [[nodiscard]] LoadedCheckpoint load(const CheckpointIdentity& who = identity('a', 'b'),
                                      double later_s = 5.0) const {
    return load_checkpoint_file(file_, who, {.utc_ns = 0, .since_boot_ns = after(later_s)}, 60.0);
  }
  [[nodiscard]] LoadedCheckpoint load_signed_by(const polhode_key& key) const {
    const Moment now{.since_boot_ns = after(5.0)};
    return load_checkpoint_file(file_, identity('a', 'b'), now, 60.0, &key);
  }
  static std::int64_t after(double later_s) {
    return kStepped.since_boot_ns + static_cast<std::int64_t>(1e9 * later_s);
  }
  static std::vector<std::uint8_t> content_of(const LoadedCheckpoint& loaded) {
    return {loaded.content.begin(), loaded.content.end()};
  }
  /// As somebody makes them who has altered a checkpoint.
  static std::string with_right_checksums(std::string bytes) {
    constexpr std::size_t kHeader = 240;
    constexpr std::size_t kContentCrc = 128;
    const auto put = [&bytes](std::size_t at, std::size_t first, std::size_t count) {
      const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data()) + first;
      const std::uint32_t crc = crc32_iso_hdlc({data, count});
      std::memcpy(bytes.data() + at, &crc, sizeof crc);
    };
    put(kContentCrc, kHeader, bytes.size() - kHeader);
    put(kHeader - 4, 0, kHeader - 4);
    return bytes;
  }
  [[nodiscard]] std::string bytes() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void replace(const std::string& bytes) const {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes;
  }

  static constexpr Moment kStepped{.utc_ns = 1'000'000'000'000, .since_boot_ns = 400'000'000'000};

  std::array<char, 36> boot_ = this_boot();
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
  const std::string good = bytes();
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
  const std::string good = bytes();
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
  EXPECT_NE(load(identity('a', 'b'), 61.0).refusal, "");
  EXPECT_NE(load(identity('a', 'b'), -1.0).refusal, "");  // from the future
}

TEST_F(CheckpointFile, OfThisBootIsAsOldAsTheClockSaysThatNobodySets) {
  ASSERT_TRUE(write(content_));
  for (const double set_s : {-2.0, 2.0, -1e6, 1e6}) {
    const Moment now{.utc_ns = kStepped.utc_ns + static_cast<std::int64_t>(1e9 * set_s),
                     .since_boot_ns = after(5.0)};
    const LoadedCheckpoint loaded = load_checkpoint_file(file_, identity('a', 'b'), now, 60.0);
    EXPECT_EQ(loaded.refusal, "") << set_s;
    EXPECT_DOUBLE_EQ(loaded.age_s, 5.0);
  }
}

TEST_F(CheckpointFile, OfAnotherBootIsAsOldAsTheUtcClockSays) {
  boot_.fill('0');
  ASSERT_TRUE(write(content_));
  const auto at = [this](double later_s) {
    return load_checkpoint_file(
        file_,
        identity('a', 'b'),
        {.utc_ns = kStepped.utc_ns + static_cast<std::int64_t>(1e9 * later_s), .since_boot_ns = 3},
        60.0);
  };
  EXPECT_EQ(at(7.0).refusal, "");
  EXPECT_DOUBLE_EQ(at(7.0).age_s, 7.0);
  EXPECT_NE(at(61.0).refusal, "");
  EXPECT_NE(at(-1.0).refusal, "");
}

/// Checksums are for accidents: who alters a checkpoint on purpose makes them right.
TEST_F(CheckpointFile, WithAKeyOnlyTheOneThatTheKeySignedIsTaken) {
  polhode_key key{};
  key.octets[3] = 7;
  polhode_key other = key;
  other.octets[3] = 8;
  const char* refusal = "not signed by the key of commands";
  ASSERT_TRUE(write(content_, &key));
  EXPECT_EQ(load_signed_by(key).refusal, "");
  EXPECT_EQ(load_signed_by(other).refusal, refusal);
  EXPECT_TRUE(load_signed_by(other).content.empty());
  EXPECT_EQ(load().refusal, "") << "who has no key takes it as before";
  ASSERT_TRUE(write(content_));
  EXPECT_EQ(load_signed_by(key).refusal, refusal);
  // The parts of two that were signed, with checksums made right.
  ASSERT_TRUE(write(content_, &key));
  const std::string one = bytes();
  ASSERT_TRUE(write(std::vector<std::uint8_t>{9, 9, 9, 4, 5, 6, 7}, &key));
  const std::string two = bytes();
  for (std::size_t from = 0; from < one.size(); from += 4) {
    for (std::size_t to = from + 4; to <= one.size(); to += 4) {
      std::string mixed = one;
      mixed.replace(from, to - from, two, from, to - from);
      mixed = with_right_checksums(mixed);
      replace(mixed);
      const bool is_one_of_them = mixed == one || mixed == two;
      EXPECT_EQ(load_signed_by(key).refusal, is_one_of_them ? "" : refusal) << from << ' ' << to;
    }
  }
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
  const std::string first = bytes();
  ASSERT_TRUE(write(std::vector<std::uint8_t>{8, 9}));
  std::ifstream before(checkpoint_before(file_), std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(before), {}), first);
}

TEST_F(CheckpointFile, ThatIsNotThereIsRefused) { EXPECT_NE(load().refusal, ""); }

TEST_F(CheckpointFile, AFailedWriteLeavesTheOldOne) {
  ASSERT_TRUE(write(content_));
  CheckpointPlaces full = places_;
  full.beside = folder_.path() / "absent/new";
  EXPECT_FALSE(write_checkpoint_file(full, CheckpointStamp{}, std::vector<std::uint8_t>{9}));
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
    EXPECT_TRUE(load().bytes.empty());
    EXPECT_EQ(load_whole_checkpoint(file_, BuildId{}).refusal, "") << "a replay was told which";
  }
}

}  // namespace
}  // namespace polhode::platform::checkpoint_file_test
