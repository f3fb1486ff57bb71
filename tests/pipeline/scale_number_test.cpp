// Each change of the unit of lengths: a new number in the rows, and one event.
#include <gtest/gtest.h>

#include <string_view>
#include <utility>
#include <vector>

#include "bench.hpp"
#include "packets_of.hpp"
#include "state_of.hpp"
#include "tests/bus/motion_packet.hpp"

namespace polhode::scale_number_test {
namespace {

using namespace bench;

constexpr int kFrames = 24;

/// What one step says of the scale.
struct Told {
  MotionState motion;
  std::uint32_t number_in_packet = 0;
  std::vector<bus::EventPacket> events;  ///< of the scale
};

class ScaleNumberOfRows : public ::testing::Test {
 protected:
  ScaleNumberOfRows() : pictures_(images_of_turning(kFrames)) {}

  /// A length of one in the first picture.
  static Parameters with_length() {
    Parameters p = parameters();
    p.scale = {.known_length_m = 1.0,
               .points_px = {{{120.0, 105.0}, {200.0, 130.0}}},
               .frame_timestamp_ns = Bench::kSecond_ns};
    return p;
  }

  Told show(int frame, Bench* b) {
    const StepOutput& out = b->show(pictures_[static_cast<std::size_t>(frame)]);
    Told told{.motion = out.motion, .events = {}};
    for (const auto& packet : packets_of<bus::MotionPacket>(out)) {
      told.number_in_packet = bus::from_packet(packet).scale_number;
    }
    for (const auto& event : packets_of<bus::EventPacket>(out)) {
      const auto id = static_cast<bus::EventId>(event.id);
      if (id == bus::EventId::kScaleKnown || id == bus::EventId::kScaleUnknown) {
        told.events.push_back(event);
      }
    }
    return told;
  }

  std::vector<Picture> pictures_;
};

std::string_view text_of(const bus::EventPacket& event) {
  return {event.text.data(), event.text_octets};
}

// verifies: SHP-15
TEST_F(ScaleNumberOfRows, RisesByOneWithEachChange_AndEachIsOneEvent) {
  Bench b(with_length());
  MotionState last;
  int changes = 0;
  for (int i = 0; i < kFrames; ++i) {
    const Told told = show(i, &b);
    const MotionState& m = told.motion;
    EXPECT_EQ(told.number_in_packet, m.scale_number % 16);
    const bool changed = std::pair(m.scale_known, m.metres_per_mu) !=
                         std::pair(last.scale_known, last.metres_per_mu);
    const bool first_map = m.target_frame != last.target_frame;
    EXPECT_EQ(m.scale_number, last.scale_number + (changed || first_map ? 1U : 0U)) << i;
    ASSERT_EQ(told.events.size(), changed ? 1U : 0U) << i;
    if (changed) {
      EXPECT_EQ(told.events[0].value[0], m.metres_per_mu);
      EXPECT_GT(told.events[0].value[1], 0.0);
      EXPECT_NE(text_of(told.events[0]).find(last.scale_known ? "before: 0." : "before: map units"),
                std::string_view::npos)
          << text_of(told.events[0]);
      ++changes;
    }
    last = m;
  }
  EXPECT_GE(changes, 2) << "read, and read anew as the map grew";
}

TEST_F(ScaleNumberOfRows, ThatMetresEnd_IsAnEventToo) {
  Bench b(with_length());
  constexpr int kBefore = 12;
  Told told;
  for (int i = 0; i < kBefore; ++i) {
    told = show(i, &b);
  }
  ASSERT_TRUE(told.motion.scale_known);
  const MotionState before = told.motion;
  // A diameter that the length contradicts by far, at its next reading.
  Component::State& s = state_of(*b.component);
  ASSERT_TRUE(add_reading({.source = ScaleSource::kDiameter, .metres_per_mu = 500.0, .sigma = 1.0},
                          s.scale.readings));
  s.scale.keyframes_at_reading = 0;
  told = show(kBefore, &b);
  EXPECT_FALSE(told.motion.scale_known);
  EXPECT_EQ(told.motion.metres_per_mu, 1.0);
  EXPECT_EQ(told.motion.scale_number, before.scale_number + 1);
  ASSERT_EQ(told.events.size(), 1U);
  EXPECT_EQ(told.events[0].id, static_cast<std::uint16_t>(bus::EventId::kScaleUnknown));
  EXPECT_EQ(told.events[0].value[0], before.metres_per_mu);
  EXPECT_EQ(told.events[0].value[1], told.motion.scale_number);
}

}  // namespace
}  // namespace polhode::scale_number_test
