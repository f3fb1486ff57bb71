// Whole packets to send, and readers to take them.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "../platform/temporary_folder.hpp"
#include "bus/telemetry.hpp"
#include "tests/bus/motion_packet.hpp"
#include "transport/client/c/polhode_bus.h"

namespace polhode::platform {

using Octets = std::vector<std::uint8_t>;

/// Motion packet number `number`; its sequence count is the number's low 14 bits, its frame the
/// number.
inline Octets motion_packet(std::uint32_t number) {
  MotionState state;
  state.frame = number;
  state.timestamp_ns = number;
  Octets octets(kMotionPacketOctets);
  EXPECT_EQ(encode_motion(state, {}, static_cast<std::uint16_t>(number), octets), octets.size());
  return octets;
}

/// The C client, closed with its owner.
class Reader {
 public:
  explicit Reader(const std::string& address) : bus_(std::make_unique<polhode_bus>()) {
    result_ = polhode_bus_open(bus_.get(), address.c_str());
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { polhode_bus_close(bus_.get()); }

  [[nodiscard]] int opened() const { return result_; }
  /// Empty when none comes in time.
  Octets next(int timeout_ms = 0) {
    std::array<std::uint8_t, POLHODE_PACKET_OCTETS_MAX> packet{};
    const int octets = polhode_bus_next(bus_.get(), packet.data(), packet.size(), timeout_ms);
    EXPECT_GE(octets, 0);
    return {packet.begin(), packet.begin() + std::max(octets, 0)};
  }
  int to_end() { return polhode_bus_to_end(bus_.get()); }
  [[nodiscard]] const polhode_bus& bus() const { return *bus_; }

 private:
  std::unique_ptr<polhode_bus> bus_;
  int result_ = -1;
};

/// A folder of its own that goes with the test.
class Folder {
 public:
  [[nodiscard]] std::string operator/(const std::string& name) const {
    return folder_.path() / name;
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace polhode::platform
