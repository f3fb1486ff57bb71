#include "camera/replay/file_octets.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <system_error>

#include "os/linux/descriptor.hpp"

namespace polhode::platform {
namespace {

std::string last_error() { return "cannot be read: " + std::generic_category().message(errno); }

}  // namespace

std::optional<std::string> read_file(const std::filesystem::path& file,
                                     std::vector<std::uint8_t>& octets,
                                     std::size_t octets_max) {
  octets.clear();
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (in.get() < 0 || ::fstat(in.get(), &status) != 0) {
    return last_error();
  }
  if (!S_ISREG(status.st_mode)) {
    return "not a regular file";
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > octets_max) {
    return "the file has " + std::to_string(size) + " octets; there is room for " +
           std::to_string(octets_max);
  }
  octets.resize(size);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::read(in.get(), octets.data() + done, size - done);
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count <= 0) {
      return count < 0 ? last_error() : "the file shrank while it was read";
    }
    done += static_cast<std::size_t>(count);
  }
  return std::nullopt;
}

}  // namespace polhode::platform
