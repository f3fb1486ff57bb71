// Notifications to a service manager (systemd): the run is ready, it makes progress, what it
// is doing, that it stops. Without one, nothing.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstdint>
#include <string_view>

namespace polhode::platform {

class ServiceManager {
 public:
  /// From NOTIFY_SOCKET and WATCHDOG_USEC of the environment.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready() { notify("READY=1\nSTATUS=running"); }
  void stopping() { notify("STOPPING=1\nSTATUS=stopping"); }
  void status(std::string_view line);
  /// Notifies the watchdog. To be called after real progress and never else; sent on once a quarter
  /// of the watchdog's time has passed since the last notification.
  void progress(std::int64_t now_ns);

  /// 0: there is no watchdog.
  [[nodiscard]] std::int64_t watchdog_ns() const { return watchdog_ns_; }

 private:
  void notify(std::string_view text);

  int socket_ = -1;
  sockaddr_un address_{};
  socklen_t address_bytes_ = 0;
  std::int64_t watchdog_ns_ = 0;
  std::int64_t notified_ns_ = 0;
};

}  // namespace polhode::platform
