// The component's answers to commands, received over the bus.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/bus_reader.hpp"
#include "bus/packets.hpp"
#include "transport/client/c/polhode_bus.h"

namespace polhode::platform {

/// Listens from its making on, so that the answer to a command that is sent next is not missed.
/// Each command is answered by one event. Those of other senders are distinguished by the
/// sequence counts, where the commands have such.
class BusAnswers {
 public:
  /// @param address of telemetry, as `polhode bus follow` takes it.
  /// @throws UnusableInput: it cannot be opened.
  BusAnswers(const std::string& address, int apid_first);

  /// Count in the answer of each command, as bus::answered_sequence() gives it; 0: no count.
  using Sequences = std::vector<std::uint16_t>;

  /// Before the commands are sent: passes over what is there already, as in a file, and reads what
  /// the ports have counted so far, which comes once a second. Later refusals are then
  /// distinguished from these.
  void begin(double timeout_s);

  /// Prints each answer as it comes.
  /// @param commands  one entry for each.
  /// @return commands refused, of those.
  /// @throws RunFailure: the ports refused them, and why; or no answer to one within the time.
  std::size_t wait(const Sequences& commands, double timeout_s);

 private:
  /// Takes from `waiting` what the packet answers.
  /// @return commands that it refuses, of those.
  std::size_t read(std::span<const std::uint8_t> octets, Sequences* waiting);
  /// Reads on until the time is over. @return the next packet; empty: none came.
  std::span<const std::uint8_t> next(std::chrono::steady_clock::time_point end);
  /// Since begin(), as words: how many by which reason; empty: none, or not reported.
  [[nodiscard]] std::string refused_at_ports() const;
  /// Nobody else has sent since begin(), and none of these passed: no answer will come.
  [[nodiscard]] bool all_refused(std::size_t commands) const;

  std::string address_;
  int apid_first_;
  BusReader bus_;
  std::array<std::uint8_t, POLHODE_PACKET_OCTETS_MAX> packet_{};
  std::optional<bus::CommandLinkPacket> before_;  ///< at begin()
  std::optional<bus::CommandLinkPacket> last_;    ///< that came after it
};

}  // namespace polhode::platform
