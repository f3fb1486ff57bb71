// The writing end of the shared-memory ring.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "transport/address.hpp"
#include "transport/datagram/datagram.hpp"

namespace polhode::platform {

namespace ring {
struct Ring;
}

/// Overwrites the oldest packet; no reader can delay or stop it.
class RingWriter {
 public:
  /// Creates the shared memory (mode 0600), or goes on in what an earlier writer of the same user
  /// left: its readers stay attached. What that one left of another size or layout, or open to
  /// others, is replaced. The name stays when the writer goes.
  /// @throws UnusableInput: another user's, or another writer has it, or it cannot be made.
  explicit RingWriter(const Address& address);
  RingWriter(RingWriter&& other) noexcept
      : file_(std::move(other.file_)), ring_(std::exchange(other.ring_, nullptr)) {}
  RingWriter& operator=(RingWriter&&) = delete;
  RingWriter(const RingWriter&) = delete;
  RingWriter& operator=(const RingWriter&) = delete;
  ~RingWriter();

  /// Of shared memory.
  static std::size_t octets();

  /// At most limits::kPacketOctets.
  void send(std::span<const std::uint8_t> packet);
  [[nodiscard]] const SendCounts& counts() const { return counts_; }

 private:
  Descriptor file_;  ///< locked, so that there is one writer
  ring::Ring* ring_ = nullptr;
  SendCounts counts_;
};

}  // namespace polhode::platform
