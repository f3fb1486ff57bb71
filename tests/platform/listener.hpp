// Notifications to a service manager, for tests.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <string>

namespace polhode::platform {

/// The manager's end of the socket.
class Listener {
 public:
  explicit Listener(const std::string& path)
      : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.c_str(), path.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Listener() { ::close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  [[nodiscard]] std::string next() const {
    char text[300];
    const ssize_t bytes = ::recv(socket_, text, sizeof text, 0);
    return bytes < 0 ? std::string() : std::string(text, static_cast<std::size_t>(bytes));
  }

 private:
  int socket_;
};

}  // namespace polhode::platform
