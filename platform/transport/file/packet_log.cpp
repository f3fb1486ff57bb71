#include "transport/file/packet_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "os/linux/file_faults.hpp"

namespace polhode::platform {

PacketLog::PacketLog(const std::filesystem::path& file)
    : file_(::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640)) {
  if (file_ < 0) {
    fail_to_open(file, file.string() + ": cannot be written", errno);
  }
}

PacketLog::~PacketLog() { ::close(file_); }

bool PacketLog::append(std::span<const std::uint8_t> packets) {
  const ssize_t written = ::write(file_, packets.data(), packets.size());
  const bool whole = written == static_cast<ssize_t>(packets.size());
  octets_ += written > 0 ? static_cast<std::uint64_t>(written) : 0;
  failures_ += whole ? 0 : 1;
  return whole;
}

}  // namespace polhode::platform
