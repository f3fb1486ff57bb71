// The packets of a step, decoded.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "bus/packets.hpp"
#include "bus/splitter.hpp"
#include "bus/telemetry.hpp"
#include "pipeline/component.hpp"

namespace polhode::bench {

/// Every packet of a step of this kind, in order.
template <typename Packet>
std::vector<Packet> packets_of(const StepOutput& out) {
  std::vector<Packet> found;
  for (std::size_t at = 0; at < out.packets.size();) {
    const bus::StreamPiece piece = bus::next_piece(out.packets, at, true);
    EXPECT_EQ(piece.kind, bus::PieceKind::kPacket);
    if (piece.header.apid == BusOptions{}.apid_first + Packet::layout().number) {
      Packet packet;
      const auto header =
          bus::decode(Packet::layout(), out.packets.subspan(at, piece.octets), &packet);
      EXPECT_TRUE(header.ok()) << (header ? "" : header.error().message);
      found.push_back(packet);
    }
    at += piece.octets;
  }
  return found;
}

}  // namespace polhode::bench
