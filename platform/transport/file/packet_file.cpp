#include "transport/file/packet_file.hpp"

namespace polhode::platform {

void PacketFile::append(std::span<const std::uint8_t> packets) {
  out_.write(packets.data(), packets.size());
  hash_.add(packets);
  octets_ += packets.size();
}

std::string PacketFile::finish() {
  out_.close();
  return hash_.finish();
}

}  // namespace polhode::platform
