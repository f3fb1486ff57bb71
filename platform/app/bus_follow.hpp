// polhode bus follow and send: the bus as it runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace polhode::platform {

struct BusFollowArguments {
  std::string address;
  bool json = false;  ///< one object a line instead of a table
  int apid_first = 0x1A0;
  int count = 0;           ///< end after so many packets; 0: never
  double timeout_s = 0.0;  ///< end when none comes for so long; 0: never
};

/// Prints packets as they come, until interrupted. Losses and damage are reported on standard
/// error.
/// @throws UnusableInput: the address cannot be opened.
void follow_bus(const BusFollowArguments& arguments);

struct BusSendArguments {
  std::string address;             ///< unix: or udp:
  std::vector<std::string> words;  ///< the command as CommandWriter takes it
  int apid_first = 0x1A0;
  int sequence = 0;          ///< sequence count of the first command, 1 .. 16383; 0: none
  std::string key;           ///< file; empty: the command is not signed
  std::uint64_t number = 0;  ///< of the first signed command; 0: the time
  std::string wait;  ///< address of telemetry to read the answers from; empty: not waited for
  double timeout_s = 10.0;  ///< for all answers
};

/// Sends one command. `table_load` and `table_activate` in one call: between them a word `+`.
/// @throws UnusableInput: no such command; RunFailure: nobody takes it, or, where the answer is
/// waited for, it was refused or not answered.
void send_command(const BusSendArguments& arguments);

}  // namespace polhode::platform
