// All that the configuration names to send packets to, and to take commands from.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "transport/command_ports.hpp"
#include "transport/datagram/datagram.hpp"
#include "transport/file/flat_file.hpp"
#include "transport/shm/ring_writer.hpp"

namespace polhode::platform {

/// As in a configuration:
///   [transport]
///   send = ["unix:/run/polhode/telemetry", "udp:127.0.0.1:10015", "shm:/polhode",
///   "file:flight.ccsds"] receive = "unix:/run/polhode/commands"
struct TransportSettings {
  std::vector<std::string> send;
  std::vector<std::string> receive;  ///< empty: no commands
  CommandSettings commands = {};     ///< who may give them
};

/// Opens everything before the first frame; sends without waiting and without heap.
class Transports {
 public:
  /// @param utc_ns  now: where the numbers of signed commands begin when none were kept.
  /// @throws UnusableInput naming the address.
  explicit Transports(const TransportSettings& settings, std::int64_t utc_ns = 0);

  /// Whole packets end to end, as StepOutput::packets. Every transport gets every packet; one that
  /// does not take it is counted and delays none of the others.
  void send(std::span<const std::uint8_t> packets);

  /// Sends packets that wait for a reader with a full queue: at a quiet moment, and before the end.
  void flush();

  /// Command packets that have arrived, as CommandPorts::receive(); valid until the next call.
  std::span<const std::span<const std::uint8_t>> received();

  /// Over all transports.
  [[nodiscard]] SendCounts counts() const;
  /// Packets that the disk did not take, over all file: transports.
  [[nodiscard]] std::uint64_t refused_by_disk() const;
  /// Of the address with this number, from 0, as in the settings.
  [[nodiscard]] const SendCounts& counts(std::size_t number) const;
  [[nodiscard]] const std::string& address(std::size_t number) const {
    return senders_[number].address;
  }
  [[nodiscard]] std::size_t senders() const { return senders_.size(); }
  [[nodiscard]] const CommandPorts& commands() const { return ports_; }

 private:
  struct Sender {
    std::string address;
    std::variant<DatagramSender, RingWriter, FlatFile> to;
  };
  void add_sender(const std::string& text);

  std::vector<Sender> senders_;
  CommandPorts ports_;
};

}  // namespace polhode::platform
