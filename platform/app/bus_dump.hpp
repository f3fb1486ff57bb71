// polhode bus dump: the packets of a file, decoded for people or as JSON.
#pragma once

#include <filesystem>

namespace polhode::platform {

struct BusDumpArguments {
  std::filesystem::path file;
  bool json = false;  ///< one object a line instead of a table
  int apid_first = 0x1A0;
};

/// Damage is reported on standard error and skipped; the packets around it are printed.
/// @throws UnusableInput: the file cannot be read, or holds octets but not one packet.
void dump_bus(const BusDumpArguments& arguments);

}  // namespace polhode::platform
