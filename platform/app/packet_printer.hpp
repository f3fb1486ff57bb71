// Packets of any kind decoded as text or JSON, by the field table; losses are reported.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "bus/splitter.hpp"

namespace polhode::platform {

struct PrinterOptions {
  std::string source;  ///< named in reports of damage
  bool json = false;   ///< one object a line instead of a table
  int apid_first = 0x1A0;
};

/// Prints packets one by one on standard output and counts errors.
class PacketPrinter {
 public:
  explicit PacketPrinter(PrinterOptions options) : options_(std::move(options)) {}

  void packet(const bus::PacketHeader& header, std::span<const std::uint8_t> octets);

  /// Octets that belong to no packet. Reported on standard error only when a packet follows: a file
  /// of something else gets one line, not hundreds.
  void damage(std::uint64_t offset, std::size_t octets);

  /// As damage(), where the reader has reported it already.
  void count_damage(std::uint64_t octets) { damaged_total_ += octets; }
  /// Packets without our content: idle ones, and other applications' without our CRC.
  void passed_over(std::uint64_t idle, std::uint64_t foreign) {
    idle_ += idle;
    foreign_ += foreign;
  }

  /// The last line, on standard error.
  void finish();

  [[nodiscard]] int apid_first() const { return options_.apid_first; }
  [[nodiscard]] std::uint64_t packets() const { return packets_; }
  [[nodiscard]] std::uint64_t damaged_octets() const { return damaged_total_; }

 private:
  void print_damage();
  void count_missing(const bus::PacketHeader& header);

  PrinterOptions options_;
  std::map<std::uint16_t, std::uint16_t> last_sequence_;  ///< per APID
  std::map<std::uint16_t, std::uint64_t>
      unknown_;  ///< packets per APID that is not in the field table
  std::uint64_t packets_ = 0;
  std::uint64_t missing_ = 0;
  std::uint64_t damaged_total_ = 0;
  std::uint64_t idle_ = 0;
  std::uint64_t foreign_ = 0;
  std::uint64_t damage_offset_ = 0;  ///< of the damage since the last packet
  std::uint64_t damage_octets_ = 0;
};

/// A stream that arrives in pieces, cut into packets.
class StreamReader {
 public:
  /// @param more    the octets that arrived
  /// @param at_end  nothing will follow: the rest is damage
  void add(std::span<const std::uint8_t> more, bool at_end, PacketPrinter& printer);

 private:
  bool after_damage_ = false;
  std::vector<std::uint8_t> buffered_;
  std::uint64_t offset_ = 0;  ///< of buffered_ in the stream
};

}  // namespace polhode::platform
