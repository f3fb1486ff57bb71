#include "transport/file/flat_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "errors.hpp"

namespace polhode::platform {

FlatFile::FlatFile(const Address& address)
    : file_(
          ::open(address.path.c_str(),
                 O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK,  // the last is for a pipe
                 S_IRUSR | S_IWUSR)) {
  if (file_.get() < 0) {
    throw UnusableInput(fmt::format(
        "{}: cannot be opened: {}", address.text, std::generic_category().message(errno)));
  }
}

void FlatFile::send(std::span<const std::uint8_t> packet) {
  const ssize_t octets = ::write(file_.get(), packet.data(), packet.size());
  if (octets == static_cast<ssize_t>(packet.size())) {
    ++counts_.sent;
  } else {
    ++counts_.dropped;
  }
}

}  // namespace polhode::platform
