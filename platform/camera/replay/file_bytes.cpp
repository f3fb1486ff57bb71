#include "camera/replay/file_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <system_error>
#include <utility>

#include "errors.hpp"
#include "os/linux/descriptor.hpp"
#include "os/linux/file_faults.hpp"

namespace polhode::platform {
namespace {

struct Fault {
  std::string words;
  int error = 0;  ///< errno; 0: the file itself is at fault
};

Fault last_error() { return {"cannot be read: " + std::generic_category().message(errno), errno}; }

std::optional<Fault> read(const std::filesystem::path& file,
                          std::vector<std::uint8_t>& bytes,
                          std::size_t bytes_max) {
  bytes.clear();
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (in.get() < 0 || ::fstat(in.get(), &status) != 0) {
    return last_error();
  }
  if (!S_ISREG(status.st_mode)) {
    return Fault{"not a regular file"};
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > bytes_max) {
    return Fault{"the file has " + std::to_string(size) + " octets; there is room for " +
                 std::to_string(bytes_max)};
  }
  bytes.resize(size);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::read(in.get(), bytes.data() + done, size - done);
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count <= 0) {
      return count < 0 ? last_error() : Fault{"the file shrank while it was read"};
    }
    done += static_cast<std::size_t>(count);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> read_file(const std::filesystem::path& file,
                                     std::vector<std::uint8_t>& bytes,
                                     std::size_t bytes_max) {
  std::optional<Fault> fault = read(file, bytes, bytes_max);
  return fault ? std::optional(std::move(fault->words)) : std::nullopt;
}

void read_file_at_start(const std::filesystem::path& file,
                        const std::string& what,
                        std::vector<std::uint8_t>& bytes,
                        std::size_t bytes_max) {
  const std::optional<Fault> fault = read(file, bytes, bytes_max);
  if (fault && fault->error != 0) {
    fail_at_start(what + ": cannot be read", fault->error);
  }
  if (fault) {
    throw UnusableInput(what + ": " + fault->words);
  }
}

}  // namespace polhode::platform
