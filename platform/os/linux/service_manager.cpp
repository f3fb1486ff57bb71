#include "os/linux/service_manager.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace polhode::platform {
namespace {

std::int64_t watchdog_from_environment() {
  const char* period = std::getenv("WATCHDOG_USEC");
  const char* process = std::getenv("WATCHDOG_PID");
  if (period == nullptr || (process != nullptr && std::atol(process) != ::getpid())) {
    return 0;
  }
  return std::max(0LL, std::atoll(period)) * 1000;
}

}  // namespace

ServiceManager::ServiceManager() {
  const char* path = std::getenv("NOTIFY_SOCKET");
  const std::size_t length = path == nullptr ? 0 : std::strlen(path);
  if (length < 2 || length >= sizeof address_.sun_path || (path[0] != '/' && path[0] != '@')) {
    return;
  }
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  address_.sun_family = AF_UNIX;
  std::memcpy(address_.sun_path, path, length);
  if (path[0] == '@') {
    address_.sun_path[0] = '\0';  // a name that is no file
  }
  address_bytes_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  watchdog_ns_ = watchdog_from_environment();
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) {
    ::close(socket_);
  }
}

/// Never waits: a manager that does not listen must not hold the run up.
void ServiceManager::notify(std::string_view text) {
  if (socket_ >= 0) {
    (void)::sendto(socket_,
                   text.data(),
                   text.size(),
                   MSG_NOSIGNAL | MSG_DONTWAIT,
                   reinterpret_cast<const sockaddr*>(&address_),
                   address_bytes_);
  }
}

void ServiceManager::status(std::string_view line) {
  char text[256];
  const int bytes =
      std::snprintf(text, sizeof text, "STATUS=%.*s", static_cast<int>(line.size()), line.data());
  notify({text, std::min(static_cast<std::size_t>(std::max(bytes, 0)), sizeof text - 1)});
}

void ServiceManager::progress(std::int64_t now_ns) {
  if (watchdog_ns_ > 0 && now_ns - notified_ns_ >= watchdog_ns_ / 4) {
    notified_ns_ = now_ns;
    notify("WATCHDOG=1");
  }
}

}  // namespace polhode::platform
