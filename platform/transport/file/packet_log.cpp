#include "transport/file/packet_log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "os/linux/file_owner.hpp"

namespace polhode::platform {

PacketLog::PacketLog(const std::filesystem::path& file)
    : file_(::open(
          file.c_str(),
          O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC,  // a FIFO waits
          0640)) {
  if (file_.get() < 0 && errno == ELOOP) {
    throw UnusableInput(file.string() + ": is a symbolic link; a file of its own is needed");
  }
  if (file_.get() < 0) {
    fail_to_open(file, file.string() + ": cannot be written", errno);
  }
  const std::string problem = problem_of_owner(file_.get(), S_IWGRP | S_IWOTH);
  if (!problem.empty()) {
    throw UnusableInput(file.string() + ": " + problem);
  }
}

bool PacketLog::append(std::span<const std::uint8_t> packets) {
  const ssize_t written = ::write(file_.get(), packets.data(), packets.size());
  const bool whole = written == static_cast<ssize_t>(packets.size());
  octets_ += written > 0 ? static_cast<std::uint64_t>(written) : 0;
  failures_ += whole ? 0 : 1;
  return whole;
}

}  // namespace polhode::platform
