// Commands as text: "set_range frame_timestamp_ns=5 range_m=12.5".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace polhode::platform {

/// Makes packets of lines, and remembers what was loaded so that TABLE_ACTIVATE needs no CRC given.
///   NAME [argument=value]...             an array's values between commas: q_IC=1,0,0,0
///   table_load KEY=value...              parameters as in a configuration, features.count_max=500
///   table_activate                       of all that was loaded since the last one
///   hex 19AFC000...                      octets as they are, right or wrong
class CommandWriter {
 public:
  explicit CommandWriter(int apid_first) : apid_first_(apid_first) {}

  /// Gives the packets sequence counts from here on; 0: none. Up to bus::kSequenceModulus - 1.
  void count_from(std::uint16_t sequence) { sequence_ = sequence; }

  /// @throws UnusableInput naming the command, the argument and what is allowed. Ranges are left to
  /// the receiver, which has to check them anyway.
  std::vector<std::uint8_t> packet(std::string_view line);

 private:
  std::vector<std::uint8_t> table_load(const std::vector<std::string_view>& words);
  std::vector<std::uint8_t> table_activate();
  void seal(std::uint8_t code, std::vector<std::uint8_t>& octets);

  int apid_first_;
  std::uint16_t sequence_ = 0;        ///< of the next packet
  std::vector<std::uint8_t> loaded_;  ///< octets of all entries since the last activation
};

}  // namespace polhode::platform
