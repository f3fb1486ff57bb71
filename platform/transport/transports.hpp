// All that the configuration names to send packets to, and to take commands from.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "transport/datagram/datagram.hpp"
#include "transport/file/flat_file.hpp"
#include "transport/shm/ring_writer.hpp"

namespace polhode::platform {

/// As in a configuration:
///   [transport]
///   send = ["unix:/run/polhode/telemetry", "udp:127.0.0.1:10015", "shm:/polhode", "file:flight.ccsds"]
///   receive = "unix:/run/polhode/commands"
struct TransportSettings {
  std::vector<std::string> send;
  std::string receive;  ///< empty: no commands
};

/// Opens everything before the first frame; sends without waiting and without heap.
class Transports {
 public:
  /// @throws UnusableInput naming the address.
  explicit Transports(const TransportSettings& settings);

  /// Whole packets end to end, as StepOutput::packets. Every transport gets every packet; one that
  /// does not take it is counted and delays none of the others.
  void send(std::span<const std::uint8_t> packets);

  /// Tries again what waits for a reader with a full queue: at a quiet moment, and before the end.
  void flush();

  /// Command packets that have arrived; valid until the next call. Never waits.
  std::span<const std::span<const std::uint8_t>> received();

  /// Over all transports.
  [[nodiscard]] SendCounts counts() const;
  [[nodiscard]] std::uint64_t commands_received() const;
  /// One line a transport, for people.
  [[nodiscard]] std::string report() const;

 private:
  struct Sender {
    std::string address;
    std::variant<DatagramSender, RingWriter, FlatFile> to;
  };
  std::vector<Sender> senders_;
  std::optional<DatagramReceiver> receiver_;
};

}  // namespace polhode::platform
