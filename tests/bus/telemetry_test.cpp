#include "bus/telemetry.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "motion_state_samples.hpp"
#include "tests/bus/motion_packet.hpp"

namespace polhode::telemetry_test {
namespace {

using Packet = std::array<std::uint8_t, kMotionPacketOctets>;
namespace layout = bus::motion_layout;

Packet encoded(const MotionState& state, std::uint16_t sequence = 0) {
  Packet packet{};
  EXPECT_EQ(encode_motion(state, {}, sequence, packet), kMotionPacketOctets);
  return packet;
}

void expect_equal(const MotionState& a, const MotionState& b) {
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.timestamp_ns, b.timestamp_ns);
  EXPECT_EQ(a.mode, b.mode);
  EXPECT_EQ(a.pose_valid, b.pose_valid);
  EXPECT_EQ(a.rate_valid, b.rate_valid);
  EXPECT_EQ(a.velocity_valid, b.velocity_valid);
  EXPECT_EQ(a.scale_known, b.scale_known);
  EXPECT_EQ(a.scale_number, b.scale_number);
  EXPECT_EQ(a.q_CT, b.q_CT);
  EXPECT_EQ(a.p_CT, b.p_CT);
  EXPECT_EQ(a.v_C, b.v_C);
  EXPECT_EQ(a.w_T_rad_s, b.w_T_rad_s);
  EXPECT_EQ(a.sigma_att_rad, b.sigma_att_rad);
  EXPECT_EQ(a.sigma_pos, b.sigma_pos);
  EXPECT_EQ(a.sigma_vel, b.sigma_vel);
  EXPECT_EQ(a.sigma_rate_rad_s, b.sigma_rate_rad_s);
  EXPECT_EQ(a.cov_pose, b.cov_pose);
  EXPECT_EQ(a.cov_v, b.cov_v);
  EXPECT_EQ(a.cov_w, b.cov_w);
  EXPECT_EQ(a.features, b.features);
  EXPECT_EQ(a.matches, b.matches);
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.landmarks, b.landmarks);
  EXPECT_EQ(a.keyframes, b.keyframes);
}

TEST(MotionPacket, ComesBackBitForBit) {
  for (std::uint64_t number = 0; number < 500; ++number) {
    const MotionState state = random_motion_state(number);
    const Result<MotionState> back = decode_motion(encoded(state));
    ASSERT_TRUE(back.ok()) << number << " " << back.error().message;
    expect_equal(state, back.value());
  }
}

// verifies: SHP-15
TEST(MotionPacket, CarriesTheNumberOfTheScaleModulo16_BesideTheFlags) {
  MotionState state = random_motion_state(2);
  state.scale_known = true;
  state.pose_valid = state.rate_valid = state.velocity_valid = false;
  state.scale_number = 0x35;
  const Packet packet = encoded(state);
  EXPECT_EQ(packet[layout::kFlags], 0x50 | layout::kFlagScaleKnown);
  EXPECT_EQ(decode_motion(packet).value().scale_number, 5U);
  // A value that is not finite takes its own flag down, and leaves the number.
  state.pose_valid = true;
  state.p_CT[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(encoded(state)[layout::kFlags], 0x50 | layout::kFlagScaleKnown);
}

TEST(MotionPacket, SaysCountTimeAndApidInItsHeader) {
  MotionState state = random_motion_state(1);
  state.timestamp_ns = 1'700'000'000'250'000'000;
  Packet packet{};
  ASSERT_EQ(encode_motion(state, {.apid_first = 0x123}, 0x3FFF, packet), kMotionPacketOctets);
  bus::PacketHeader header;
  ASSERT_TRUE(bus::read_header(packet, header));
  EXPECT_EQ(header.apid, 0x123);
  EXPECT_EQ(header.sequence, 0x3FFF);
  EXPECT_EQ(header.total_octets, kMotionPacketOctets);
  EXPECT_EQ(header.seconds, 1'700'000'000U);
  EXPECT_EQ(header.fraction_2_24, 1U << 22U);
}

// verifies: BUS-03
TEST(MotionPacket, HoldsZerosWhereItsFlagIsDown) {
  MotionState state = random_motion_state(3);
  state.pose_valid = state.rate_valid = state.velocity_valid = state.scale_known = false;
  state.scale_number = 0;
  state.p_CT = {1.0, 2.0, 3.0};
  state.w_T_rad_s = {1.0, 2.0, 3.0};
  state.v_C = {1.0, 2.0, 3.0};
  state.sigma_att_rad = state.sigma_pos = state.sigma_vel = state.sigma_rate_rad_s = 0.5;
  const Packet packet = encoded(state);
  for (std::size_t i = layout::kQ_CT; i < layout::kFrame; ++i) {
    EXPECT_EQ(packet[i], 0) << i;
  }
  EXPECT_EQ(packet[layout::kFlags], 0);
}

// verifies: BUS-03
TEST(MotionPacket, NeverCarriesANonFiniteValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity}) {
    MotionState state = random_motion_state(4);
    state.pose_valid = state.rate_valid = state.velocity_valid = true;
    state.p_CT[1] = bad;
    state.sigma_rate_rad_s = bad;
    state.v_C[2] = bad;
    const Packet packet = encoded(state);
    EXPECT_EQ(packet[layout::kFlags] & 0x07, 0);
    for (std::size_t i = layout::kQ_CT; i < layout::kCov_pose; i += 8) {
      EXPECT_NE(bus::get_u16(packet, i) & 0x7FF0, 0x7FF0)
          << i;  // the exponent of what is not finite
    }
    EXPECT_TRUE(decode_motion(packet).ok());
  }
}

TEST(MotionPacket, IsNotWrittenWhereItDoesNotFit) {
  std::array<std::uint8_t, kMotionPacketOctets - 1> small{};
  small.fill(0xAA);
  EXPECT_EQ(encode_motion(random_motion_state(5), {}, 0, small), 0U);
  for (const std::uint8_t octet : small) {
    EXPECT_EQ(octet, 0xAA);
  }
}

// verifies: BUS-02
TEST(MotionPacket, IsRefusedWithAnyBitFlipped) {
  Packet packet = encoded(random_motion_state(6));
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    packet[bit / 8] = static_cast<std::uint8_t>(packet[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_FALSE(decode_motion(packet).ok()) << bit;
    packet[bit / 8] = static_cast<std::uint8_t>(packet[bit / 8] ^ (1U << (bit % 8)));
  }
}

/// Damages one field, makes the CRC right again, and returns what the reader says.
std::string refusal(std::size_t offset, std::uint8_t octet) {
  MotionState state = random_motion_state(7);
  state.pose_valid = true;
  Packet packet = encoded(state);
  packet[offset] = octet;
  bus::write_crc(packet);
  const Result<MotionState> back = decode_motion(packet);
  return back.ok() ? std::string() : back.error().message;
}

TEST(MotionPacket, IsRefusedByNameWhenItsContentMakesNoSense) {
  EXPECT_NE(refusal(14, 1).find("version"), std::string::npos);
  EXPECT_NE(refusal(layout::kMode, 5).find("mode"), std::string::npos);
  EXPECT_NE(refusal(5, 10).find("header"), std::string::npos);
  Packet packet = encoded(random_motion_state(8));
  EXPECT_FALSE(decode_motion(std::span(packet).first(kMotionPacketOctets - 1)).ok());
  EXPECT_FALSE(decode_motion({}).ok());
}

TEST(MotionPacket, IsRefusedWhenAValidFieldIsNotFinite) {
  MotionState state = random_motion_state(9);
  state.pose_valid = state.rate_valid = state.velocity_valid = true;
  for (const std::size_t offset : {layout::kQ_CT,
                                   layout::kP_CT,
                                   layout::kV_C,
                                   layout::kW_T_rad_s,
                                   layout::kSigma_att_rad,
                                   layout::kSigma_rate_rad_s}) {
    Packet packet = encoded(state);
    packet[offset] = 0x7F;
    packet[offset + 1] = 0xF8;
    bus::write_crc(packet);
    const Result<MotionState> back = decode_motion(packet);
    ASSERT_FALSE(back.ok()) << offset;
    EXPECT_NE(back.error().message.find("out of range"), std::string::npos);
  }
}

}  // namespace
}  // namespace polhode::telemetry_test
