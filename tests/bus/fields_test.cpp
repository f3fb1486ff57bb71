#include "bus/fields.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "base/rng.hpp"
#include "bus/packet_layout.hpp"
#include "bus/telemetry.hpp"

namespace polhode::bus::fields_test {
namespace {

using Storage = std::array<std::byte, kStructOctetsMax>;

const double kBadNumbers[] = {std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};

/// Random octets in every field: NaNs, huge numbers, control characters.
void fill_at_random(std::uint64_t seed, Storage* storage) {
  Rng rng(seed, 77);
  for (std::byte& octet : *storage) {
    octet = static_cast<std::byte>(rng.below(256));
  }
}

bool all_finite(const Layout& layout, const void* packet) {
  for (const Field& field : layout.fields) {
    for (std::size_t i = 0; i < field.count; ++i) {
      if (!std::isfinite(value_of(field, packet, i))) {
        return false;
      }
    }
  }
  return true;
}

TEST(FieldTable, FieldsFollowEachOtherOnMultiplesOfTheirSize) {
  for (const Layout* layout : packet_layouts()) {
    std::size_t octet = kHeaderOctets;
    for (const Field& field : layout->fields) {
      EXPECT_EQ(field.octet, octet) << layout->name << "." << field.name;
      EXPECT_EQ(octet % size_of(field.type), 0U) << layout->name << "." << field.name;
      octet += field.count * size_of(field.type);
    }
    EXPECT_EQ(layout->octets, octet + kCrcOctets) << layout->name;
    EXPECT_LE(layout->octets, limits::kPacketOctets) << layout->name;
  }
}

TEST(FieldTable, EveryStepsPacketsFitItsOutput) {
  std::size_t octets = 0;
  for (const Layout* layout : packet_layouts()) {
    // Those of the machine go to the transports, never into a step's output.
    const bool is_of_the_machine = layout == &PlatformPacket::layout() ||
                                   layout == &CommandLinkPacket::layout() ||
                                   layout == &PlatformEventPacket::layout();
    octets += is_of_the_machine ? 0 : layout->octets;
  }
  octets += limits::kStepEvents * event_layout::kPacketOctets + 3 * cloud_layout::kPacketOctets;
  octets +=
      (limits::kStepCommands - 1) * point_layout::kPacketOctets;  // each command may ask for one
  EXPECT_LE(octets, limits::kStepOctets);
}

TEST(Settle, LeavesNoNumberThatIsNotFinite_WhateverWasThere) {
  for (const Layout* layout : packet_layouts()) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      Storage storage{};
      fill_at_random(seed, &storage);
      sanitise(*layout, storage.data());
      ASSERT_TRUE(all_finite(*layout, storage.data())) << layout->name << " seed " << seed;
    }
  }
}

TEST(Settle, TakesAFlagDownWhenOneOfItsValuesIsNotFinite_AndZerosAllOfThem) {
  for (const double bad : kBadNumbers) {
    ModelPacket packet;
    packet.flags = model_layout::kFlagAxes | model_layout::kFlagVelocity;
    packet.q_TB = {0.5, 0.5, 0.5, 0.5};
    packet.sigma_axes_rad = {0.1F, static_cast<float>(bad), 0.1F};
    packet.v_C = {1.0, 2.0, 3.0};
    sanitise(ModelPacket::layout(), &packet);
    EXPECT_EQ(packet.flags, model_layout::kFlagVelocity);
    EXPECT_EQ(packet.q_TB, (std::array<double, 4>{}));
    EXPECT_EQ(packet.v_C[2], 3.0);
  }
}

TEST(Settle, ZerosValuesWhoseFlagIsDown) {
  ShapePacket packet;
  packet.dimensions = {1.0, 2.0, 3.0};
  packet.cylinder_radius = 4.0F;
  packet.plane_count = 3;
  sanitise(ShapePacket::layout(), &packet);
  EXPECT_EQ(packet.dimensions[1], 0.0);
  EXPECT_EQ(packet.cylinder_radius, 0.0F);
  EXPECT_EQ(packet.plane_count, 3);
}

TEST(Settle, MakesTextsPrintable_AndZeroBehindTheirEnd) {
  EventPacket packet;
  const char text[] = "a\tb\x80\0rest";
  std::copy(std::begin(text), std::end(text), packet.text.begin());
  sanitise(EventPacket::layout(), &packet);
  EXPECT_EQ(std::string(packet.text.data(), 6), std::string("a?b?\0\0", 6));
}

TEST(Packing, ComesBackBitForBit_ForEveryPacketOfTheTable) {
  for (const Layout* layout : packet_layouts()) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      Storage out{};
      Storage back{};
      fill_at_random(seed, &out);
      sanitise(*layout, out.data());
      std::vector<std::uint8_t> octets(layout->octets);
      pack_fields(*layout, out.data(), octets);
      unpack_fields(*layout, octets, back.data());
      for (const Field& field : layout->fields) {
        const std::size_t size = field.count * size_of(field.type);
        ASSERT_EQ(std::memcmp(&out[field.member], &back[field.member], size), 0)
            << layout->name << "." << field.name << " seed " << seed;
      }
    }
  }
}

TEST(Packing, IsBigEndianAtTheOffsetsOfTheTable) {
  HousekeepingPacket packet;
  packet.frame = 0x01020304;
  packet.landmarks = 0x0506;
  packet.memory_octets = 0x1112131415161718;
  std::array<std::uint8_t, housekeeping_layout::kPacketOctets> octets{};
  ASSERT_EQ(encode(HousekeepingPacket::layout(), &packet, {}, octets), octets.size());
  EXPECT_EQ(get_u32(octets, housekeeping_layout::kFrame), 0x01020304U);
  EXPECT_EQ(octets[housekeeping_layout::kFrame], 0x01);
  EXPECT_EQ(octets[housekeeping_layout::kLandmarks + 1], 0x06);
  EXPECT_EQ(octets[housekeeping_layout::kMemory_octets], 0x11);
}

// verifies: BUS-02
TEST(Decoding, RefusesEveryPacketWithAnyOneBitFlipped) {
  for (const Layout* layout : packet_layouts()) {
    Storage storage{};
    std::vector<std::uint8_t> octets(layout->octets);
    ASSERT_EQ(encode(*layout, storage.data(), {.timestamp_ns = 5}, octets), octets.size());
    Storage back{};
    ASSERT_TRUE(decode(*layout, octets, back.data()).ok()) << layout->name;
    for (std::size_t bit = 0; bit < 8 * octets.size(); ++bit) {
      octets[bit / 8] = static_cast<std::uint8_t>(octets[bit / 8] ^ (1U << (bit % 8)));
      ASSERT_FALSE(decode(*layout, octets, back.data()).ok()) << layout->name << " bit " << bit;
      octets[bit / 8] = static_cast<std::uint8_t>(octets[bit / 8] ^ (1U << (bit % 8)));
    }
  }
}

TEST(Decoding, RefusesAnEnumerationsUnknownValueByName) {
  HousekeepingPacket packet;
  packet.mode = 5;
  std::array<std::uint8_t, housekeeping_layout::kPacketOctets> octets{};
  ASSERT_EQ(encode(HousekeepingPacket::layout(), &packet, {}, octets), octets.size());
  HousekeepingPacket back;
  const Result<PacketHeader> header = decode(HousekeepingPacket::layout(), octets, &back);
  ASSERT_FALSE(header.ok());
  EXPECT_NE(header.error().message.find("mode"), std::string::npos);
}

TEST(Stream, CountsEachApidByItself_AndWrapsAtFourteenBits) {
  PacketStream stream;
  const BusOptions options;
  stream.sequence[static_cast<std::size_t>(PacketId::kEvent)] = 0x3FFF;
  for (int i = 0; i < 2; ++i) {
    stream.size = 0;
    EventPacket event;
    MotionPacket motion;
    ASSERT_TRUE(append(motion, options, &stream));
    ASSERT_TRUE(append(event, options, &stream));
    PacketHeader header;
    ASSERT_TRUE(read_header(stream.view(), header));
    EXPECT_EQ(header.apid, options.apid_first);
    EXPECT_EQ(header.sequence, i);
    ASSERT_TRUE(read_header(stream.view().subspan(motion_layout::kPacketOctets), header));
    EXPECT_EQ(header.apid, options.apid_first + 5);
    EXPECT_EQ(header.sequence, i == 0 ? 0x3FFF : 0);
  }
}

TEST(Stream, CountsWhatFindsNoRoom_SoThatAReaderSeesTheGap) {
  PacketStream stream;
  const BusOptions options;
  std::uint32_t sent = 0;
  for (int i = 0; i < 12; ++i) {
    CloudPacket cloud;
    sent += append(cloud, options, &stream) ? 1U : 0U;
  }
  EXPECT_EQ(sent, limits::kStepOctets / cloud_layout::kPacketOctets);
  EXPECT_EQ(stream.not_sent, 12 - sent);
  EXPECT_EQ(stream.sequence[static_cast<std::size_t>(PacketId::kCloud)], 12);
}

TEST(Words, AreTakenByNumber) {
  EXPECT_EQ(word_of("IDLE LOST", 0), "IDLE");
  EXPECT_EQ(word_of("IDLE LOST", 1), "LOST");
  EXPECT_EQ(word_of("IDLE LOST", 2), "");
  EXPECT_EQ(word_of("", 0), "");
}

}  // namespace
}  // namespace polhode::bus::fields_test
