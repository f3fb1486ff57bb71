// Where packets go to or come from, as a configuration writes it.
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace polhode::platform {

enum class AddressKind : std::uint8_t {
  kUnix,  ///< unix:PATH, a datagram socket in the file system
  kUdp,   ///< udp:PORT (loopback) or udp:HOST:PORT, HOST a numeric IPv4 address
  kShm,   ///< shm:/NAME, a ring in POSIX shared memory
  kFile,  ///< file:PATH, packets end to end
};

struct Address {
  AddressKind kind = AddressKind::kFile;
  std::string text;  ///< as it was given
  std::string path;  ///< of kUnix, kFile; the name of kShm
  sockaddr_in udp{};
};

/// @throws UnusableInput naming the address and what is allowed.
Address parse_address(std::string_view text);

}  // namespace polhode::platform
