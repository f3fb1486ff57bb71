// Datagram sockets: one packet each, never waiting.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bus/capacities.hpp"
#include "bus/layout.hpp"
#include "os/linux/descriptor.hpp"
#include "transport/address.hpp"

namespace polhode::platform {

/// The file of a bound Unix socket, removed with its owner; empty: there is none.
class SocketFile {
 public:
  explicit SocketFile(std::string path = {}) : path_(std::move(path)) {}
  SocketFile(SocketFile&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  SocketFile& operator=(SocketFile&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  SocketFile(const SocketFile&) = delete;
  SocketFile& operator=(const SocketFile&) = delete;
  ~SocketFile();

 private:
  std::string path_;
};

/// Has a sender an address of its own, that a reader can answer to?
enum class SenderName : std::uint8_t { kNone, kBesideReader };

/// Counts of the packets handed to one transport.
struct SendCounts {
  std::uint64_t sent = 0;
  std::uint64_t dropped = 0;    ///< the reader is there but has had no room for long
  std::uint64_t no_reader = 0;  ///< nobody has bound the address
};

/// Sends to one address. A reader may come and go at any time; sending never waits for it and never
/// fails: datagrams that it does not take are counted.
///
/// A Unix socket holds 10 datagrams of strangers (net.unix.max_dgram_qlen), which at 1000 packets a
/// second is 10 ms of a reader that does not get the processor, and all that it gets each time it
/// does. Of the one that it is connected to it holds what that one's send buffer allows (SO_SNDBUF,
/// at most net.core.wmem_max), hundreds. So a sender has a name, PATH.sender, where it can be had,
/// which this project's readers connect to. What finds the queue full waits here, in order, and
/// goes with the next calls, kRetries a call so that a reader that returns does not cost the
/// sender hundreds at once; kBacklog packets at most.
class DatagramSender {
 public:
  static constexpr std::size_t kBacklog = 512;
  static constexpr std::size_t kRetries = 16;

  /// @throws RunFailure when the system gives no socket.
  explicit DatagramSender(const Address& address, SenderName name = SenderName::kNone);

  /// Of the heap, at start.
  static constexpr std::size_t backlog_octets() { return kBacklog * sizeof(Waiting); }

  /// At most kRetries + 1 system calls, none of which waits.
  void send(std::span<const std::uint8_t> packet);
  /// Tries again all that waits.
  void flush();
  [[nodiscard]] const SendCounts& counts() const { return counts_; }

  /// For a sender of a few commands, before the first: lets the system report if nobody has bound a
  /// UDP address. A machine that is off or silent is not reported.
  void hear_refusals();
  /// Waits for such word for at most `wait_ms`.
  [[nodiscard]] bool refused(int wait_ms) const;

 private:
  enum class Outcome : std::uint8_t { kSent, kNoRoom, kNoReader };
  void retry(std::size_t packets_max);
  Outcome try_send(std::span<const std::uint8_t> packet);

  struct Waiting {
    std::size_t octets = 0;
    std::array<std::uint8_t, limits::kPacketOctets> packet{};
  };
  Descriptor socket_;
  SocketFile file_;
  std::vector<Waiting> backlog_;  ///< a ring, made at start
  std::size_t first_ = 0;
  std::size_t waiting_ = 0;
  alignas(8) std::array<std::byte, 128> to_{};  ///< a socket address of either family
  std::uint32_t to_octets_ = 0;
  SendCounts counts_;
};

/// A datagram, and its sender.
struct Received {
  std::size_t octets = 0;
  bool uid_known = false;  ///< by the system, of a Unix socket's
  uid_t uid = 0;
};

/// Receives command packets. A Unix socket's file belongs to its owner alone (mode 0600) and goes
/// with the receiver; the system reports for each datagram which user sent it.
class DatagramReceiver {
 public:
  /// @throws UnusableInput when the address is in use or cannot be bound.
  explicit DatagramReceiver(const Address& address);

  /// The oldest datagram that waits. One longer than `into` arrives cut to it.
  /// @return nothing when none waits. Never waits.
  std::optional<Received> next(std::span<std::uint8_t> into);

  /// By the system for want of room, as far as it reports them (UDP).
  [[nodiscard]] std::uint32_t dropped() const { return dropped_; }
  [[nodiscard]] bool is_unix() const { return is_unix_; }

 private:
  Descriptor socket_;
  SocketFile file_;
  bool is_unix_;
  std::uint32_t dropped_ = 0;
};

}  // namespace polhode::platform
