// A flat file of packets that grows during a flight.
#pragma once

#include <cstdint>
#include <span>

#include "transport/address.hpp"
#include "transport/datagram/datagram.hpp"

namespace polhode::platform {

/// Appends packets end to end. Each is one system call: what was sent is in the file whatever
/// happens to the process. A packet that the disk does not take whole is counted as dropped; a
/// reader resynchronises behind it. A named pipe in the place takes whole packets while it has
/// room, and is never waited for.
class FlatFile {
 public:
  /// Appends to what is there. Mode 0600. A pipe needs its reader by now.
  /// @throws UnusableInput: it cannot be opened, another process has it, or it is a file of another
  /// user or that others may write to.
  explicit FlatFile(const Address& address);
  void send(std::span<const std::uint8_t> packet);
  [[nodiscard]] const SendCounts& counts() const { return counts_; }
  /// Of the dropped packets, those that the disk did not take.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  Descriptor file_;
  SendCounts counts_;
  std::uint64_t refused_ = 0;
};

}  // namespace polhode::platform
