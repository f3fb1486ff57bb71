// All addresses that commands come to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bus/capacities.hpp"
#include "transport/command_guard.hpp"
#include "transport/datagram/datagram.hpp"

namespace polhode::platform {

/// Ports take turns, a command each, so a flood at one leaves the others their share of a step.
/// Refused datagrams take no place, and at most kReads datagrams are read from a port for one step:
/// the cost of a flood is bounded.
class CommandPorts {
 public:
  /// Datagrams of one port for one step. Chosen: eight for each command that a step takes. A MAC
  /// takes some 2 us, so 64 refused ones cost a step a fifth of a millisecond.
  static constexpr std::size_t kReads = 64;
  static constexpr std::size_t kPorts = 8;  // chosen: a few buses of a spacecraft

  /// @throws UnusableInput naming address or key.
  CommandPorts(const std::vector<std::string>& addresses,
               const CommandSettings& settings,
               std::uint64_t utc_ns);

  /// Command packets that have arrived, of each port oldest first, at most limits::kStepCommands;
  /// the rest stays for the next call. Without a key a datagram longer than a packet may be arrives
  /// cut, and so is refused by its length.
  /// @return valid until the next call. Waits for no datagram; with signed ones for their number to
  /// be kept, NumberFile::kWait at most.
  std::span<const std::span<const std::uint8_t>> receive();

  [[nodiscard]] const CommandGuard& guard() const { return guard_; }
  [[nodiscard]] std::size_t size() const { return ports_.size(); }
  /// By the system, for want of room; of a Unix socket none, as its sender gets an error.
  [[nodiscard]] std::uint32_t dropped() const;
  /// Anybody who reaches one of the ports may give commands.
  [[nodiscard]] bool open_to_all() const;

 private:
  struct Port {
    DatagramReceiver from;
    std::size_t reads = 0;  ///< for this step
  };
  bool take_one(Port& port);

  static constexpr std::size_t kOctets = limits::kPacketOctets + 1;  // one more shows a longer one
  std::vector<Port> ports_;
  CommandGuard guard_;
  std::size_t first_ = 0;  ///< port whose turn is next
  std::size_t count_ = 0;
  std::array<std::array<std::uint8_t, kOctets>, limits::kStepCommands> octets_{};
  std::array<std::span<const std::uint8_t>, limits::kStepCommands> packets_{};
};

}  // namespace polhode::platform
