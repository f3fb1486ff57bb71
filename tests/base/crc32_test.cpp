#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "base/crc.hpp"
#include "base/rng.hpp"

namespace polhode::crc32_test {
namespace {

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

/// The checksum bit by bit, as the reflected polynomial's definition reads.
std::uint32_t crc32_by_bits(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t remainder = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const std::uint32_t in = (static_cast<std::uint32_t>(byte) >> bit) & 1U;
      const std::uint32_t out = remainder & 1U;
      remainder = (remainder >> 1U) ^ ((in ^ out) != 0 ? 0xEDB88320U : 0U);
    }
  }
  return ~remainder;
}

TEST(Crc32, HasTheCheckValueOfItsName) {
  EXPECT_EQ(crc32_iso_hdlc(bytes_of("123456789")), 0xCBF43926U);
  EXPECT_EQ(crc32_iso_hdlc({}), 0U);
}

TEST(Crc32, EqualsTheBitwiseDefinition) {
  Rng rng(1, 1);
  for (std::size_t length = 0; length < 300; ++length) {
    std::vector<std::uint8_t> bytes(length);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng.next());
    EXPECT_EQ(crc32_iso_hdlc(bytes), crc32_by_bits(bytes)) << length;
  }
}

TEST(Crc32, ContinuesFromWhatComesBefore_WhereverTheBytesAreSplit) {
  const std::vector<std::uint8_t> whole = bytes_of("a checkpoint in several parts");
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    const std::span bytes(whole);
    EXPECT_EQ(crc32_iso_hdlc(bytes.subspan(cut), crc32_iso_hdlc(bytes.first(cut))),
              crc32_iso_hdlc(whole))
        << cut;
  }
}

TEST(Crc32, ChangesWithEveryBit) {
  std::vector<std::uint8_t> bytes = bytes_of("telemetry");
  const std::uint32_t before = crc32_iso_hdlc(bytes);
  for (std::uint8_t& byte : bytes) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      byte = static_cast<std::uint8_t>(byte ^ (1U << bit));
      EXPECT_NE(crc32_iso_hdlc(bytes), before);
      byte = static_cast<std::uint8_t>(byte ^ (1U << bit));
    }
  }
}

}  // namespace
}  // namespace polhode::crc32_test
