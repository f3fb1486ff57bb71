// A component that is told something, and the events that it answers with.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "../bus/command_packets.hpp"
#include "bench.hpp"
#include "packets_of.hpp"

namespace polhode::bench {

using bus::command;
using bus::CommandCode;
using bus::CommandOctets;
using bus::EventId;

inline std::optional<bus::EventPacket> event(EventId id, const StepOutput& out) {
  for (const bus::EventPacket& packet : packets_of<bus::EventPacket>(out)) {
    if (packet.id == static_cast<std::uint16_t>(id)) {
      return packet;
    }
  }
  return std::nullopt;
}

struct Commanded : Bench {
  explicit Commanded(const Parameters& p = every_frame()) : Bench(p) {}
  static Parameters every_frame() {
    Parameters p = parameters();
    p.bus.housekeeping_every_frames = 1;
    return p;
  }
  /// A dark frame (nothing to see, quick) with these commands.
  const StepOutput& step(const std::vector<CommandOctets>& commands) {
    const std::vector<std::span<const std::uint8_t>> spans(commands.begin(), commands.end());
    return component->step({.frame = frame_of(++time_s * kSecond_ns, dark), .commands = spans});
  }
  const StepOutput& step(const CommandOctets& one) { return step(std::vector<CommandOctets>{one}); }
  static bus::HousekeepingPacket housekeeping(const StepOutput& out) {
    const auto packets = packets_of<bus::HousekeepingPacket>(out);
    EXPECT_EQ(packets.size(), 1U);
    return packets.at(0);
  }
  const Picture dark = uniform(0);
};

}  // namespace polhode::bench
