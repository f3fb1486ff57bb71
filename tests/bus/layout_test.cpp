#include "bus/layout.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>

namespace polhode::bus::layout_test {
namespace {

TEST(Sequence, WrapsAtFourteenBits) {
  EXPECT_EQ(next_sequence(0), 1);
  EXPECT_EQ(next_sequence(0x3FFE), 0x3FFF);
  EXPECT_EQ(next_sequence(0x3FFF), 0);
}

TEST(Sequence, CountsMissingPacketsAcrossTheWrap) {
  EXPECT_EQ(packets_missing(5, 6), 0);
  EXPECT_EQ(packets_missing(5, 9), 3);
  EXPECT_EQ(packets_missing(0x3FFF, 0), 0);
  EXPECT_EQ(packets_missing(0x3FFE, 2), 3);
  EXPECT_EQ(packets_missing(7, 7),
            0x3FFF);  // a whole turn less one, or a repeat: the count cannot tell
}

TEST(Time, IsTheTimestampRoundedDownToTwoToTheMinus24) {
  PacketHeader header;
  set_time(1'700'000'000'500'000'000, &header);
  EXPECT_EQ(header.seconds, 1'700'000'000U);
  EXPECT_EQ(header.fraction_2_24, 1U << 23U);
  EXPECT_EQ(header.time_quality, TimeQuality::kCamera);
  set_time(999'999'999, &header);
  EXPECT_EQ(header.seconds, 0U);
  EXPECT_EQ(header.fraction_2_24, 0xFFFFFFU);  // (1 - 1e-9) 2^24 = 2^24 - 0.017, rounded down
}

TEST(Time, OutsideOfTheCodesRangeIsSaidAndZero) {
  PacketHeader header;
  for (const std::int64_t timestamp_ns : {std::int64_t{-1},
                                          std::numeric_limits<std::int64_t>::min(),
                                          std::int64_t{4'294'967'296'000'000'000}}) {
    set_time(timestamp_ns, &header);
    EXPECT_EQ(header.time_quality, TimeQuality::kOutOfRange);
    EXPECT_EQ(header.seconds, 0U);
    EXPECT_EQ(header.fraction_2_24, 0U);
  }
  set_time(4'294'967'295'999'999'999, &header);
  EXPECT_EQ(header.seconds, 0xFFFFFFFFU);
  EXPECT_EQ(header.time_quality, TimeQuality::kCamera);
}

// verifies: BUS-01
TEST(Header, HasTheOctetsOfTheStandard) {
  PacketHeader header{.apid = 0x1A0, .sequence = 0x1234, .total_octets = 178};
  header.seconds = 0x01020304;
  header.fraction_2_24 = 0x050607;
  std::array<std::uint8_t, kHeaderOctets> octets{};
  write_header(header, octets);
  const std::array<std::uint8_t, kHeaderOctets> expected{
      0x09, 0xA0, 0xD2, 0x34, 0x00, 171, 0x2F, 1, 2, 3, 4, 5, 6, 7, kLayoutVersion, 0};
  EXPECT_EQ(octets, expected);
}

TEST(Header, ComesBackAsItWasWritten) {
  const PacketHeader header{.apid = 0x7FE,
                            .sequence = 0x3FFF,
                            .total_octets = 1400,
                            .seconds = 0xFFFFFFFE,
                            .fraction_2_24 = 0xABCDEF,
                            .layout_version = 7,
                            .time_quality = TimeQuality::kOutOfRange};
  std::array<std::uint8_t, kHeaderOctets> octets{};
  write_header(header, octets);
  PacketHeader back;
  ASSERT_TRUE(read_header(octets, back));
  EXPECT_EQ(back.apid, header.apid);
  EXPECT_EQ(back.sequence, header.sequence);
  EXPECT_EQ(back.total_octets, header.total_octets);
  EXPECT_EQ(back.seconds, header.seconds);
  EXPECT_EQ(back.fraction_2_24, header.fraction_2_24);
  EXPECT_EQ(back.layout_version, header.layout_version);
  EXPECT_EQ(back.time_quality, header.time_quality);
}

TEST(Header, IsRefusedWhenAFixedBitDiffersOrItIsShort) {
  std::array<std::uint8_t, kHeaderOctets> octets{};
  write_header({.apid = 1, .sequence = 0, .total_octets = 178}, octets);
  PacketHeader back;
  ASSERT_TRUE(read_header(octets, back));
  EXPECT_FALSE(read_header(std::span(octets).first(kHeaderOctets - 1), back));
  struct Flip {
    std::size_t octet;
    std::uint8_t bits;
  };
  for (const Flip flip : {Flip{0, 0x80},
                          {0, 0x40},
                          {0, 0x20},
                          {0, 0x10},
                          {0, 0x08},
                          {2, 0x80},
                          {2, 0x40},
                          {6, 0x01},
                          {15, 0x02}}) {
    std::array<std::uint8_t, kHeaderOctets> damaged = octets;
    damaged[flip.octet] = static_cast<std::uint8_t>(damaged[flip.octet] ^ flip.bits);
    EXPECT_FALSE(read_header(damaged, back)) << flip.octet << " " << int{flip.bits};
  }
  put_u16(octets, 4, 3);  // shorter than its own header and CRC
  EXPECT_FALSE(read_header(octets, back));
}

TEST(Octets, AreBigEndianAndComeBack) {
  std::array<std::uint8_t, 8> octets{};
  put_u32(octets, 4, 0xDEADBEEF);
  EXPECT_EQ(octets[4], 0xDE);
  EXPECT_EQ(get_u32(octets, 4), 0xDEADBEEFU);
}

TEST(Crc, IsZeroOverAWholePacketAndFindsEverySingleFlippedBit) {
  std::array<std::uint8_t, 40> packet{};
  for (std::size_t i = 0; i < packet.size(); ++i) {
    packet[i] = static_cast<std::uint8_t>(7 * i + 3);
  }
  write_crc(packet);
  ASSERT_TRUE(crc_is_right(packet));
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    packet[bit / 8] = static_cast<std::uint8_t>(packet[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_FALSE(crc_is_right(packet)) << bit;
    packet[bit / 8] = static_cast<std::uint8_t>(packet[bit / 8] ^ (1U << (bit % 8)));
  }
  EXPECT_FALSE(crc_is_right(std::span(packet).first(2)));
}

}  // namespace
}  // namespace polhode::bus::layout_test
