#include "bus/splitter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "base/rng.hpp"
#include "bus/telemetry.hpp"
#include "motion_state_samples.hpp"
#include "tests/bus/motion_packet.hpp"

namespace polhode::bus::splitter_test {
namespace {

std::vector<std::uint8_t> stream_of(std::uint16_t packets) {
  std::vector<std::uint8_t> stream;
  std::array<std::uint8_t, kMotionPacketOctets> packet{};
  for (std::uint16_t i = 0; i < packets; ++i) {
    encode_motion(random_motion_state(i), {}, i, packet);
    stream.insert(stream.end(), packet.begin(), packet.end());
  }
  return stream;
}

struct Tally {
  std::vector<std::uint16_t> sequences;
  std::size_t damaged_octets = 0;
  std::size_t covered_octets = 0;
};

Tally read_all(const std::vector<std::uint8_t>& stream) {
  Tally tally;
  for (std::size_t offset = 0; offset < stream.size();) {
    const StreamPiece piece = next_piece(stream, offset, true);
    EXPECT_EQ(piece.offset, offset);
    EXPECT_GT(piece.octets, 0U);
    EXPECT_NE(piece.kind, PieceKind::kIncomplete);
    if (piece.kind == PieceKind::kPacket) {
      tally.sequences.push_back(piece.header.sequence);
    } else {
      tally.damaged_octets += piece.octets;
    }
    tally.covered_octets += piece.octets;
    offset += piece.octets;
  }
  return tally;
}

TEST(Splitter, FindsEveryPacketOfAGoodStream) {
  const Tally tally = read_all(stream_of(50));
  ASSERT_EQ(tally.sequences.size(), 50U);
  EXPECT_EQ(tally.damaged_octets, 0U);
  for (std::uint16_t i = 0; i < 50; ++i) {
    EXPECT_EQ(tally.sequences[i], i);
  }
}

// verifies: BUS-06
TEST(Splitter, LosesOnlyThePacketThatIsDamaged) {
  for (std::size_t octet = 0; octet < kMotionPacketOctets; ++octet) {
    std::vector<std::uint8_t> stream = stream_of(3);
    stream[kMotionPacketOctets + octet] ^= 0x5A;
    const Tally tally = read_all(stream);
    ASSERT_EQ(tally.sequences.size(), 2U) << octet;
    EXPECT_EQ(tally.sequences[0], 0);
    EXPECT_EQ(tally.sequences[1], 2);
    EXPECT_EQ(tally.damaged_octets, kMotionPacketOctets);
  }
}

TEST(Splitter, ResynchronisesAfterInsertedAndRemovedOctets) {
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    Rng rng(5, trial);
    std::vector<std::uint8_t> stream = stream_of(6);
    const auto place =
        static_cast<std::ptrdiff_t>(kMotionPacketOctets * 2 + rng.below(kMotionPacketOctets));
    if (trial % 2 == 0) {
      const std::size_t count = 1 + rng.below(400);
      std::vector<std::uint8_t> noise(count);
      for (std::uint8_t& octet : noise) octet = static_cast<std::uint8_t>(rng.next());
      stream.insert(stream.begin() + place, noise.begin(), noise.end());
    } else {
      stream.erase(stream.begin() + place, stream.begin() + place + 1 + rng.below(100));
    }
    const Tally tally = read_all(stream);
    EXPECT_EQ(tally.covered_octets, stream.size());
    // At most the packet cut by the damage and, for a removal, its successor are lost.
    ASSERT_GE(tally.sequences.size(), 4U) << trial;
    EXPECT_EQ(tally.sequences.front(), 0);
    EXPECT_EQ(tally.sequences.back(), 5);
  }
}

TEST(Splitter, WaitsForTheRestOfAPacketUnlessTheEndIsKnown) {
  const std::vector<std::uint8_t> stream = stream_of(1);
  for (std::size_t octets = 1; octets < stream.size(); ++octets) {
    const std::span<const std::uint8_t> front(stream.data(), octets);
    EXPECT_EQ(next_piece(front, 0, false).kind, PieceKind::kIncomplete) << octets;
    const StreamPiece last = next_piece(front, 0, true);
    EXPECT_EQ(last.kind, PieceKind::kDamaged) << octets;
    EXPECT_EQ(last.octets, octets);
  }
  EXPECT_EQ(next_piece(stream, 0, false).kind, PieceKind::kPacket);
}

TEST(Splitter, IdlePacketsAreNeitherPacketsNorDamage) {
  std::vector<std::uint8_t> idle{0x07, 0xFF, 0xC0, 0, 0, 13};
  idle.resize(20, 0x55);
  std::vector<std::uint8_t> stream = stream_of(1);
  const std::size_t packet = stream.size();
  stream.insert(stream.end(), idle.begin(), idle.end());
  stream.insert(stream.begin(), idle.begin(), idle.end());
  EXPECT_EQ(next_piece(stream, 0, true).kind, PieceKind::kIdle);
  EXPECT_EQ(next_piece(stream, 0, true).octets, idle.size());
  EXPECT_EQ(next_piece(stream, idle.size(), true).kind, PieceKind::kPacket);
  EXPECT_EQ(next_piece(stream, idle.size() + packet, true).kind, PieceKind::kIdle);
  for (std::size_t octets = 1; octets < idle.size(); ++octets) {
    const std::span<const std::uint8_t> front(idle.data(), octets);
    EXPECT_EQ(next_piece(front, 0, false).kind, PieceKind::kIncomplete) << octets;
    EXPECT_EQ(next_piece(front, 0, true).kind, PieceKind::kDamaged) << octets;
  }
  stream[5] = 200;  // a length that does not lead to a packet: the packet is found all the same
  EXPECT_EQ(read_all(stream).sequences.size(), 1U);
}

/// Without our secondary header, and without a CRC.
std::vector<std::uint8_t> foreign(std::uint8_t octets) {
  std::vector<std::uint8_t> packet{0x01, 0x23, 0xC0, 5, 0, static_cast<std::uint8_t>(octets - 7)};
  packet.resize(octets, 0xA5);
  return packet;
}

TEST(Splitter, PacketsOfOthersAreBelievedInStep_AndNotBehindDamage) {
  const std::vector<std::uint8_t> other = foreign(20);
  std::vector<std::uint8_t> stream = stream_of(1);
  stream.insert(stream.begin(), other.begin(), other.end());
  const StreamPiece piece = next_piece(stream, 0, true);
  EXPECT_EQ(piece.kind, PieceKind::kForeign);
  EXPECT_EQ(piece.octets, other.size());
  const StreamPiece damaged = next_piece(stream, 0, true, {.after_damage = true});
  EXPECT_EQ(damaged.kind, PieceKind::kDamaged);
  EXPECT_EQ(damaged.octets, other.size()) << "up to the packet that a CRC tells";
  // The same octets under one of the run's own APIDs are damage.
  EXPECT_EQ(next_piece(stream, 0, true, {.apid_first = 0x120}).kind, PieceKind::kDamaged);
  EXPECT_EQ(next_piece(stream, 0, true, {.apid_first = 0x124}).kind, PieceKind::kForeign);
}

TEST(Splitter, APacketOfOthersNeedsAnotherHeaderOrTheEndBehindIt) {
  std::vector<std::uint8_t> stream = foreign(20);
  EXPECT_EQ(next_piece(stream, 0, true).kind, PieceKind::kForeign);
  EXPECT_EQ(next_piece(stream, 0, false).kind, PieceKind::kIncomplete);
  stream.resize(30, 0xA5);
  EXPECT_EQ(next_piece(stream, 0, true).kind, PieceKind::kDamaged);
  const std::vector<std::uint8_t> hole(70);
  EXPECT_EQ(next_piece(hole, 0, true).kind, PieceKind::kDamaged);
}

TEST(Splitter, FindsNothingInNoise) {
  Rng rng(6, 0);
  std::vector<std::uint8_t> noise(100'000);
  for (std::uint8_t& octet : noise) octet = static_cast<std::uint8_t>(rng.next());
  // A false packet needs 22 fixed bits, the length and the CRC by chance: 1e5 places times 2^-43.
  const Tally tally = read_all(noise);
  EXPECT_TRUE(tally.sequences.empty());
  EXPECT_EQ(tally.damaged_octets, noise.size());
}

}  // namespace
}  // namespace polhode::bus::splitter_test
