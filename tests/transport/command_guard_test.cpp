#include "transport/command_guard.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>

#include "../bus/command_packets.hpp"
#include "base/rng.hpp"
#include "errors.hpp"
#include "signed_commands.hpp"
#include "small_files.hpp"

namespace polhode::platform::command_guard_test {
namespace {

const Octets kNoop = bus::command(bus::CommandCode::kNoop);

class CommandGuardTest : public ::testing::Test {
 protected:
  bool passes(Octets datagram) { return guard_.pass(datagram, {}).has_value(); }

  SignedCommands signed_;
  CommandGuard guard_{signed_.settings(), SignedCommands::kUtc_ns};
};

/// RFC 4231, test case 2, has a key of 4 octets; ours has 32: the same by HMAC's rule of padding.
TEST(Mac, IsHmacSha256_ItsFirst128Bits) {
  polhode_key key{};
  std::memcpy(key.octets, "Jefe", 4);
  const std::string text = "what do ya want for nothing?";
  std::array<std::uint8_t, POLHODE_MAC_OCTETS> mac{};
  ASSERT_EQ(polhode_mac(
                &key, reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), mac.data()),
            0);
  const std::array<std::uint8_t, POLHODE_MAC_OCTETS> expected{0x5b,
                                                              0xdc,
                                                              0xc1,
                                                              0x46,
                                                              0xbf,
                                                              0x60,
                                                              0x75,
                                                              0x4e,
                                                              0x6a,
                                                              0x04,
                                                              0x24,
                                                              0x26,
                                                              0x08,
                                                              0x95,
                                                              0x75,
                                                              0xc7};
  EXPECT_EQ(mac, expected);
}

// verifies: CMD-05
TEST_F(CommandGuardTest, TakesASignedCommandOnce_AndCountsWhatItRefusesByReason) {
  const Octets good = signed_.sign(kNoop);
  Octets datagram = good;
  const auto packet = guard_.pass(datagram, {});
  ASSERT_TRUE(packet);
  EXPECT_EQ(Octets(packet->begin(), packet->end()), kNoop);
  EXPECT_FALSE(passes(good));
  EXPECT_FALSE(passes(kNoop));
  EXPECT_FALSE(passes({}));
  EXPECT_FALSE(passes(SignedCommands('b').sign(kNoop, signed_.last() + 1)));
  Octets longer = signed_.sign(kNoop);
  longer.push_back(0);
  EXPECT_FALSE(passes(longer));
  const CommandCounts& counts = guard_.counts();
  EXPECT_EQ(counts.received, 6U);
  EXPECT_EQ(counts.passed, 1U);
  EXPECT_EQ(counts.refused_number, 1U);
  EXPECT_EQ(counts.refused_mac, 1U);
  EXPECT_EQ(counts.refused_form, 3U);
  EXPECT_EQ(guard_.highest(), SignedCommands::kUtc_ns + 1);
}

TEST_F(CommandGuardTest, EveryBitCounts) {
  const Octets good = signed_.sign(kNoop);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Octets changed = good;
    changed[bit / 8] = static_cast<std::uint8_t>(changed[bit / 8] ^ (1U << (bit % 8)));
    ASSERT_FALSE(passes(changed)) << bit;
  }
  EXPECT_TRUE(passes(good));
}

TEST_F(CommandGuardTest, TakesThoseThatOvertakeEachOther_AndNoneThatLeftTheWindow) {
  const auto at = [&](std::uint64_t after) {
    return passes(signed_.sign(kNoop, SignedCommands::kUtc_ns + after));
  };
  EXPECT_FALSE(at(0)) << "what was signed before the first start";
  EXPECT_TRUE(at(1000));
  EXPECT_TRUE(at(500));
  for (std::uint64_t i = 0; i < CommandWindow::kNumbers; ++i) {
    EXPECT_TRUE(at(2000 + i));
  }
  EXPECT_FALSE(at(1000));
  EXPECT_FALSE(at(999)) << "never taken, but too old to tell";
  EXPECT_TRUE(at(1500));
  EXPECT_FALSE(at(2000 + 5));
}

// verifies: CMD-05
TEST(CommandWindow, TakesEachNumberOnce_InAnyOrder) {
  Rng rng(5, 0);
  CommandWindow window(100);
  std::vector<int> taken(1200);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t number = 101 + rng.next() % 1000 * static_cast<std::uint64_t>(i) / 20000;
    if (window.is_new(number)) {
      window.take(number);
      ++taken[number];
    }
  }
  EXPECT_LE(*std::max_element(taken.begin(), taken.end()), 1);
  EXPECT_GT(std::accumulate(taken.begin(), taken.end(), 0), 100);
}

TEST(CommandGuard, RemembersOverARestart_AndBeginsAgainWithANewKey) {
  SignedCommands signed_commands;
  CommandSettings settings = signed_commands.settings();
  Octets first = signed_commands.sign(kNoop);
  const Octets captured = first;
  {
    CommandGuard guard(settings, SignedCommands::kUtc_ns);
    EXPECT_TRUE(guard.pass(first, {}));
    guard.keep_numbers();
    EXPECT_NE(guard.remark(), "");
    EXPECT_THROW(CommandGuard(settings, SignedCommands::kUtc_ns), RunFailure) << "in use";
  }
  {
    CommandGuard again(settings, 0);  // a clock that was set back makes no difference
    EXPECT_EQ(again.remark(), "");
    Octets repeated = captured;
    EXPECT_FALSE(again.pass(repeated, {}));
    Octets next = signed_commands.sign(kNoop);
    EXPECT_TRUE(again.pass(next, {}));
    again.keep_numbers();
  }
  const SignedCommands other('c');
  settings.key = other.settings().key;
  {
    CommandGuard renewed(settings, SignedCommands::kUtc_ns);
    Octets low = other.sign(kNoop, 1);
    EXPECT_TRUE(renewed.pass(low, {}));
    renewed.keep_numbers();
  }
  settings.key = signed_commands.settings().key;  // the first key returns
  CommandGuard back(settings, 0);
  Octets repeated = captured;
  EXPECT_FALSE(back.pass(repeated, {}));
  EXPECT_EQ(back.remark(), "");
}

TEST(CommandGuard, CountsCommandsWhoseNumberTheDiskRefuses_AndPassesThem) {
  SignedCommands signed_commands;
  CommandGuard guard(signed_commands.settings(), SignedCommands::kUtc_ns);
  Octets first = signed_commands.sign(kNoop);
  Octets second = signed_commands.sign(kNoop);
  {
    const SmallFiles none(0);
    EXPECT_TRUE(guard.pass(first, {}));
    EXPECT_TRUE(guard.pass(second, {}));
    guard.keep_numbers();
    guard.keep_numbers();  // where the first did not wait long enough
  }
  EXPECT_EQ(guard.counts().numbers_not_kept, 2U);
  guard.keep_numbers();
  EXPECT_EQ(guard.counts().numbers_not_kept, 2U);
}

TEST(KeyFile, HoldsDigitsForItsOwnerAlone) {
  const Folder folder;
  const std::string file = folder / "key";
  const std::string digits(2 * POLHODE_KEY_OCTETS, '7');
  const auto write = [&](const std::string& text, mode_t mode) {
    std::ofstream(file, std::ios::binary) << text;
    ASSERT_EQ(::chmod(file.c_str(), mode), 0);
  };
  write(digits, 0600);
  EXPECT_EQ(read_key(file).octets[31], 0x77);
  for (const std::string& text :
       {digits + "\n\n", digits + "00", digits.substr(2), std::string(), digits.substr(1) + "g"}) {
    write(text, 0600);
    EXPECT_THROW((void)read_key(file), UnusableInput) << text;
  }
  write(digits, 0640);
  EXPECT_THROW((void)read_key(file), UnusableInput);
  EXPECT_THROW((void)read_key(folder / "absent"), UnusableInput);
  EXPECT_THROW((void)read_key(folder / "."), UnusableInput);
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THROW((void)read_key(folder / "pipe"), UnusableInput);
}

/// A small number every day; POLHODE_COMMAND_CAMPAIGN=1 runs a million and 100,000.
TEST_F(CommandGuardTest, TakesNoneOfRandomAndRepeatedOnes) {
  const bool all = std::getenv("POLHODE_COMMAND_CAMPAIGN") != nullptr;
  const int randoms = all ? 1'000'000 : 20'000;
  const int repeats = all ? 100'000 : 5'000;
  Rng rng(41, 0);
  for (int i = 0; i < randoms; ++i) {
    Octets datagram = i % 2 == 0
                          ? signed_.sign(kNoop, SignedCommands::kUtc_ns + 1 + rng.next() % 1000)
                          : Octets(rng.next() % 80);
    const std::size_t from = i % 2 == 0 ? datagram.size() - 1 - rng.next() % 16 : 0;
    const Octets before = datagram;
    for (std::size_t at = from; at < datagram.size(); ++at) {
      datagram[at] = static_cast<std::uint8_t>(rng.next());
    }
    if (i % 2 != 0 && datagram.size() > 5) {  // the right length: the MAC decides
      datagram[4] = 0;
      datagram[5] = static_cast<std::uint8_t>(datagram.size() - 7);
    }
    if (datagram != before || datagram.empty()) {
      ASSERT_FALSE(passes(datagram)) << i;
    }
  }
  std::vector<Octets> captured;
  for (int i = 0; i < 100; ++i) {
    captured.push_back(signed_.sign(kNoop));
    ASSERT_TRUE(passes(captured.back()));
  }
  for (int i = 0; i < repeats; ++i) {
    ASSERT_FALSE(passes(captured[rng.next() % captured.size()])) << i;
  }
  EXPECT_EQ(guard_.counts().passed, 100U);
  EXPECT_EQ(guard_.counts().refused_number, static_cast<unsigned>(repeats));
  EXPECT_GT(guard_.counts().refused_mac, static_cast<unsigned>(randoms) / 2);
}

}  // namespace
}  // namespace polhode::platform::command_guard_test
