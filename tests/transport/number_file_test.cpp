#include "transport/number_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <thread>

#include "errors.hpp"
#include "packets.hpp"
#include "signed_commands.hpp"
#include "small_files.hpp"

namespace polhode::platform::number_file_test {
namespace {

using Clock = std::chrono::steady_clock;

/// The thread may not get the processor in time.
bool is_kept(NumberFile& numbers, std::uint64_t number) {
  const Clock::time_point end = Clock::now() + std::chrono::seconds(60);
  Kept kept = numbers.keep(number);
  while (kept == Kept::kLate && Clock::now() < end) {
    kept = numbers.keep(number);
  }
  return kept == Kept::kYes;
}

class NumberFileTest : public testing::Test {
 protected:
  /// All octets of the key are this one.
  static polhode_key key_of(char octet) {
    polhode_key key{};
    std::fill(std::begin(key.octets), std::end(key.octets), static_cast<std::uint8_t>(octet));
    return key;
  }
  [[nodiscard]] NumberFile open(std::uint64_t utc_ns, char key = 'a') const {
    return {file_, key_of(key), utc_ns};
  }
  /// In a run that then ends.
  void take(char key, std::uint64_t number) const {
    NumberFile numbers(file_, key_of(key), 7);
    EXPECT_TRUE(is_kept(numbers, number));
  }
  void spoil(int octet) const {
    std::fstream in(file_, std::ios::in | std::ios::out | std::ios::binary);
    in.seekp(octet);
    in.put('\x55');
  }
  static constexpr int kPair = 64;  ///< octets of a key's two places

  Folder folder_;
  std::string file_ = folder_ / "window";
};

/// As a power cut may leave it: one place of the two torn, or both.
TEST(NumberFile, TornPlacesBeginAtThePresent) {
  const SignedCommands signed_commands;
  const std::string file = signed_commands.settings().window;
  const auto open = [&](std::uint64_t utc_ns) {
    return NumberFile(file, signed_commands.key(), utc_ns);
  };
  {
    NumberFile numbers = open(7);
    EXPECT_EQ(numbers.number(), 7U);
    EXPECT_TRUE(is_kept(numbers, 100));
    EXPECT_TRUE(is_kept(numbers, 200));
  }
  EXPECT_EQ(open(7).number(), 200U);
  const auto spoil = [&](int octet) {
    std::fstream in(file, std::ios::in | std::ios::out | std::ios::binary);
    in.seekp(octet);
    in.put('\x55');
  };
  {
    NumberFile numbers = open(7);
    EXPECT_TRUE(is_kept(numbers, 300));
  }
  spoil(40);
  EXPECT_EQ(open(400).number(), 400U) << "the greatest may have stood there";
  spoil(8);
  spoil(40);
  NumberFile begun = open(900);
  EXPECT_EQ(begun.number(), 900U);
  EXPECT_NE(begun.remark(), "");
}

TEST(NumberFile, IsTheUsersOwn) {
  const SignedCommands signed_commands;
  const Folder folder;
  const auto open = [&](const std::string& file) {
    const NumberFile numbers(file, signed_commands.key(), 7);
  };
  EXPECT_THROW(open(folder / "absent/window"), UnusableInput);
  EXPECT_THROW(open(folder / "."), UnusableInput);
  std::ofstream(folder / "open") << "";
  ASSERT_EQ(::chmod((folder / "open").c_str(), 0666), 0);
  EXPECT_THROW(open(folder / "open"), UnusableInput);
  ASSERT_EQ(::symlink((folder / "open").c_str(), (folder / "link").c_str()), 0);
  EXPECT_THROW(open(folder / "link"), UnusableInput);
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(open(folder / "pipe"), UnusableInput);
}

/// A captured command of the first key would be good again if its numbers began again.
TEST_F(NumberFileTest, EachKeyHasItsOwn_AndReturnsToThem) {
  take('a', 1000);
  {
    NumberFile other = open(2000, 'b');
    EXPECT_EQ(other.number(), 0U) << "nothing was captured with a new key";
    EXPECT_NE(other.remark(), "");
    EXPECT_TRUE(is_kept(other, 50));
  }
  EXPECT_EQ(open(0, 'a').number(), 1000U);
  EXPECT_EQ(open(0, 'b').number(), 50U);
  EXPECT_EQ(open(0, 'a').number(), 1000U);
  EXPECT_EQ(open(0, 'a').remark(), "");
}

TEST_F(NumberFileTest, APairThatDoesNotTellWhoseItWasMayBeAnyKeysThatIsNotFound) {
  for (const char key : {'a', 'b', 'c'}) {
    take(key, 1000);
  }
  spoil(kPair + 8);
  spoil(kPair + 40);
  EXPECT_EQ(open(500, 'c').number(), 1000U);
  EXPECT_EQ(open(500, 'd').number(), 500U);
  EXPECT_EQ(open(600, 'b').number(), 600U) << "its pair may be the damaged one";
  EXPECT_EQ(open(0, 'b').number(), 600U);
  EXPECT_EQ(open(0, 'a').number(), 1000U);
}

TEST_F(NumberFileTest, TornWhereANewKeyWasAdded_ItBeginsAtThePresent) {
  take('a', 1000);
  (void)open(7, 'b');
  ASSERT_EQ(::truncate(file_.c_str(), kPair + 20), 0);
  EXPECT_EQ(open(300, 'b').number(), 300U);
  ASSERT_EQ(::truncate(file_.c_str(), 2 * kPair + 32), 0);
  EXPECT_EQ(open(400, 'b').number(), 400U);
  EXPECT_EQ(open(0, 'a').number(), 1000U);
}

TEST_F(NumberFileTest, HoldsSoManyKeysAndRefusesMore) {
  for (std::size_t i = 0; i < NumberFile::kKeys; ++i) {
    (void)open(7, static_cast<char>('a' + i));
  }
  EXPECT_NE(refusal_of<UnusableInput>([&] { (void)open(7, 'z'); }).find("name a new file"),
            std::string::npos);
  EXPECT_EQ(open(7, 'a').remark(), "");
}

/// A unit whose start ends with status 2 is not started again; a disk may get well.
TEST_F(NumberFileTest, FaultsOfTheDiskAreNoFaultOfTheSettings) {
  {
    const SmallFiles none(0);
    EXPECT_NE(refusal_of<RunFailure>([&] { (void)open(7); }).find("File too large"),
              std::string::npos);
  }
  const FewFiles none(0);
  const std::string refused = refusal_of<RunFailure>([&] { (void)open(7); });
  EXPECT_NE(refused.find("Too many open files"), std::string::npos) << refused;
}

/// Of a write that was cut short the call shows no error: what an earlier one left does not count.
ssize_t write_a_part(int file, const void* data, std::size_t octets, off_t at) {
  const ssize_t written = ::pwrite(file, data, octets / 2, at);
  errno = EACCES;
  return written;
}

TEST_F(NumberFileTest, AWriteThatIsCutShortIsAFullDisk) {
  const std::string refused =
      refusal_of<RunFailure>([&] { NumberFile(file_, key_of('a'), 7, write_a_part); });
  EXPECT_NE(refused.find("No space left on device"), std::string::npos) << refused;
}

std::atomic<bool> g_hangs = false;

/// A disk that hangs, until set otherwise.
ssize_t write_when_it_may(int file, const void* data, std::size_t octets, off_t at) {
  while (g_hangs) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return ::pwrite(file, data, octets, at);
}

TEST_F(NumberFileTest, ADiskThatHangsHoldsNobodyUp_AndTheNumberGetsThereInTheEnd) {
  {
    NumberFile numbers(file_, key_of('a'), 7, write_when_it_may);
    g_hangs = true;
    // Let go in the end in any case, so that a fault here is a failure, and no hang.
    std::thread later([] {
      for (int i = 0; i < 2000 && g_hangs; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      g_hangs = false;
    });
    const Clock::time_point begin = Clock::now();
    for (std::uint64_t i = 1; i <= 1000; ++i) {
      EXPECT_EQ(numbers.keep(100 + i), Kept::kLate);
    }
    EXPECT_TRUE(g_hangs) << "the first waited for kWait, the others not at all";
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(10));
    g_hangs = false;
    EXPECT_TRUE(is_kept(numbers, 1100));
    later.join();
  }
  EXPECT_EQ(open(0).number(), 1100U);
}

}  // namespace
}  // namespace polhode::platform::number_file_test
