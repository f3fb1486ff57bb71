#include "transport/file/flat_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "os/linux/file_lock.hpp"
#include "os/linux/file_owner.hpp"

namespace polhode::platform {

FlatFile::FlatFile(const Address& address)
    : file_(
          ::open(address.path.c_str(),
                 O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK,  // the last is for a pipe
                 S_IRUSR | S_IWUSR)) {
  if (file_.get() < 0) {
    fail_to_open(address.path, address.text + ": cannot be opened", errno);
  }
  struct stat status {};
  const bool known = ::fstat(file_.get(), &status) == 0;
  const std::string problem =
      known && S_ISREG(status.st_mode) ? problem_of_owner(file_.get(), S_IWGRP | S_IWOTH) : "";
  if (!problem.empty()) {
    throw UnusableInput(fmt::format("{}: {}", address.text, problem));
  }
  if (!known || S_ISREG(status.st_mode) || S_ISFIFO(status.st_mode)) {  // no /dev/null
    lock_file(file_.get(), address.text);
  }
}

void FlatFile::send(std::span<const std::uint8_t> packet) {
  const ssize_t octets = ::write(file_.get(), packet.data(), packet.size());
  if (octets == static_cast<ssize_t>(packet.size())) {
    ++counts_.sent;
  } else {
    ++counts_.dropped;
    const bool is_of_a_pipe = octets < 0 && (errno == EAGAIN || errno == EPIPE);
    refused_ += is_of_a_pipe ? 0 : 1;
  }
}

}  // namespace polhode::platform
