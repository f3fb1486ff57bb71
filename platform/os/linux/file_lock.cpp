#include "os/linux/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>

#include "errors.hpp"
#include "os/linux/file_faults.hpp"

namespace polhode::platform {
namespace {

/// "1: FLOCK  ADVISORY  WRITE 1234 08:01:5678 0 EOF" is a line of it. 0: not found.
int holder_of(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    return 0;
  }
  std::ifstream locks("/proc/locks");
  std::string line;
  while (std::getline(locks, line)) {
    int pid = 0;
    unsigned major_number = 0;
    unsigned minor_number = 0;
    unsigned long inode = 0;
    if (std::sscanf(line.c_str(),
                    "%*s FLOCK %*s %*s %d %x:%x:%lu",
                    &pid,
                    &major_number,
                    &minor_number,
                    &inode) == 4 &&
        inode == status.st_ino && major_number == major(status.st_dev) &&
        minor_number == minor(status.st_dev)) {
      return pid > 0 ? pid : 0;
    }
  }
  return 0;
}

}  // namespace

void lock_file(int descriptor, const std::string& what) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) {
    return;
  }
  if (errno != EWOULDBLOCK) {
    throw RunFailure(what + ": cannot be locked: " + std::generic_category().message(errno));
  }
  const int pid = holder_of(descriptor);
  throw RunFailure(what + ": " + (pid > 0 ? "process " + std::to_string(pid) : "another process") +
                   " has it");
}

Descriptor lock_beside(const std::filesystem::path& file) {
  const std::string name = file.string() + ".lock";
  Descriptor lock(::open(
      name.c_str(), O_RDONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (lock.get() < 0) {
    fail_to_open(name, name + ": cannot be made", errno);
  }
  lock_file(lock.get(), file.string());
  return lock;
}

}  // namespace polhode::platform
