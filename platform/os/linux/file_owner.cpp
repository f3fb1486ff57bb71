#include "os/linux/file_owner.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

namespace polhode::platform {
namespace {

std::string of_another(uid_t owner) {
  return "belongs to user " + std::to_string(owner) + ", not to " + std::to_string(::geteuid());
}

}  // namespace

std::string problem_of_owner(int descriptor, mode_t forbidden) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    return "cannot be looked at: " + std::generic_category().message(errno);
  }
  if (!S_ISREG(status.st_mode)) {
    return "is no regular file";
  }
  if (status.st_uid != ::geteuid()) {
    return of_another(status.st_uid);
  }
  if ((status.st_mode & forbidden) != 0) {
    std::array<char, 8> mode{};
    std::snprintf(mode.data(), mode.size(), "%04o", status.st_mode & 07777U);
    return std::string("is open to others: mode ") + mode.data();
  }
  return {};
}

std::string stranger_at(const std::filesystem::path& file) {
  struct stat status {};
  const bool known = ::lstat(file.c_str(), &status) == 0;
  return known && status.st_uid != ::geteuid() ? of_another(status.st_uid) : "";
}

}  // namespace polhode::platform
