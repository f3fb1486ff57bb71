#include "transport/datagram/datagram.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/assert.hpp"
#include "errors.hpp"
#include "os/linux/file_faults.hpp"

namespace polhode::platform {
namespace {

int open_socket(AddressKind kind) {
  const int family = kind == AddressKind::kUnix ? AF_UNIX : AF_INET;
  const int fd = ::socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) {
    fail_at_start("no socket is to be had", errno);
  }
  return fd;
}

sockaddr_un unix_address(const std::string& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  std::memcpy(
      out.sun_path, path.c_str(), path.size() + 1);  // parse_address() has seen to its length
  return out;
}

const sockaddr* as_socket_address(const void* address) {
  return static_cast<const sockaddr*>(address);
}

/// A socket file that nobody listens at any more was left behind by a process that died.
void remove_if_dead(const Address& address, const sockaddr_un& to) {
  struct stat status {};
  if (::lstat(address.path.c_str(), &status) != 0) {
    return;
  }
  if (!S_ISSOCK(status.st_mode)) {
    throw UnusableInput(fmt::format("{}: is there and is no socket", address.text));
  }
  const Descriptor probe(open_socket(AddressKind::kUnix));
  if (::connect(probe.get(), as_socket_address(&to), sizeof to) == 0) {
    throw RunFailure(fmt::format("{}: another process listens there", address.text));
  }
  if (errno == ECONNREFUSED) {
    ::unlink(address.path.c_str());
  }
}

void bind_unix(int fd, const Address& address) {
  const sockaddr_un to = unix_address(address.path);
  remove_if_dead(address, to);
  const mode_t before = ::umask(0177);  // the file is never, not even for a moment, open to others
  const int failed = ::bind(fd, as_socket_address(&to), sizeof to);
  const int error = errno;
  ::umask(before);
  if (failed != 0) {
    fail_at_start(address.text + ": cannot be bound", error);
  }
}

constexpr std::string_view kSenderSuffix = ".sender";
constexpr int kSendBuffer_octets = 1 << 20;  // the system gives what it allows

/// A name for a sender beside its reader's. Without one it works, too: the reader's queue is then
/// short. So a folder that is not there or another sender in the place is no failure.
SocketFile bind_beside(int fd, const Address& reader) {
  Address own = reader;
  own.path += kSenderSuffix;
  if (own.path.size() >= sizeof(sockaddr_un::sun_path)) {
    return SocketFile();
  }
  try {
    bind_unix(fd, own);
  } catch (const UnusableInput&) {
    return SocketFile();
  } catch (const RunFailure&) {
    return SocketFile();
  }
  return SocketFile(own.path);
}

}  // namespace

SocketFile::~SocketFile() {
  if (!path_.empty()) {
    ::unlink(path_.c_str());
  }
}

DatagramSender::DatagramSender(const Address& address, SenderName name)
    : socket_(open_socket(address.kind)), backlog_(kBacklog) {
  static_assert(sizeof(sockaddr_un) <= sizeof to_);
  if (address.kind == AddressKind::kUnix) {
    const sockaddr_un to = unix_address(address.path);
    std::memcpy(to_.data(), &to, sizeof to);
    to_octets_ = sizeof to;
    if (name == SenderName::kBesideReader) {
      (void)::setsockopt(
          socket_.get(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer_octets, sizeof kSendBuffer_octets);
      file_ = bind_beside(socket_.get(), address);
    }
  } else {
    std::memcpy(to_.data(), &address.udp, sizeof address.udp);
    to_octets_ = sizeof address.udp;
  }
}

void DatagramSender::hear_refusals() {
  // Of a connected socket alone the system passes on what the other side answers. Where there is no
  // way to the address, sending fails as before.
  (void)::connect(socket_.get(), as_socket_address(to_.data()), to_octets_);
}

bool DatagramSender::refused(int wait_ms) const {
  pollfd waiting{.fd = socket_.get(), .events = 0, .revents = 0};
  int error = 0;
  socklen_t octets = sizeof error;
  return ::poll(&waiting, 1, wait_ms) > 0 &&
         ::getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &octets) == 0 &&
         error == ECONNREFUSED;
}

DatagramSender::Outcome DatagramSender::try_send(std::span<const std::uint8_t> packet) {
  const auto octets = ::sendto(socket_.get(),
                               packet.data(),
                               packet.size(),
                               MSG_DONTWAIT | MSG_NOSIGNAL,
                               as_socket_address(to_.data()),
                               to_octets_);
  if (octets == static_cast<ssize_t>(packet.size())) {
    return Outcome::kSent;
  }
  // A reader that is still connected to a sender that has died (EPERM) finds out soon.
  const bool nobody = errno == ENOENT || errno == ECONNREFUSED || errno == EACCES;
  return nobody ? Outcome::kNoReader : Outcome::kNoRoom;
}

void DatagramSender::flush() { retry(kBacklog); }

void DatagramSender::retry(std::size_t packets_max) {
  for (std::size_t tried = 0; tried < packets_max && waiting_ > 0; ++tried) {
    const Waiting& oldest = backlog_[first_];
    const Outcome outcome = try_send(std::span(oldest.packet).first(oldest.octets));
    if (outcome == Outcome::kNoRoom) {
      return;
    }
    counts_.sent += outcome == Outcome::kSent ? 1 : 0;
    counts_.no_reader += outcome == Outcome::kNoReader ? 1 : 0;
    first_ = (first_ + 1) % kBacklog;
    --waiting_;
  }
}

void DatagramSender::send(std::span<const std::uint8_t> packet) {
  POLHODE_ASSERT(packet.size() <= limits::kPacketOctets, packet.size());
  retry(kRetries);
  const Outcome outcome = waiting_ > 0 ? Outcome::kNoRoom : try_send(packet);
  counts_.sent += outcome == Outcome::kSent ? 1 : 0;
  counts_.no_reader += outcome == Outcome::kNoReader ? 1 : 0;
  if (outcome != Outcome::kNoRoom) {
    return;
  }
  if (waiting_ == kBacklog) {
    ++counts_.dropped;
    return;
  }
  Waiting& last = backlog_[(first_ + waiting_) % kBacklog];
  std::copy(packet.begin(), packet.end(), last.packet.begin());
  last.octets = packet.size();
  ++waiting_;
}

DatagramReceiver::DatagramReceiver(const Address& address)
    : socket_(open_socket(address.kind)), is_unix_(address.kind == AddressKind::kUnix) {
  const int enable = 1;
  if (is_unix_) {
    // With each datagram, who sent it. Before the address is there: none comes without.
    if (::setsockopt(socket_.get(), SOL_SOCKET, SO_PASSCRED, &enable, sizeof enable) != 0) {
      fail_at_start(address.text + ": senders stay unknown", errno);
    }
    bind_unix(socket_.get(), address);
    file_ = SocketFile(address.path);
    return;
  }
  // With each datagram, how many the system has dropped before it.
  (void)::setsockopt(socket_.get(), SOL_SOCKET, SO_RXQ_OVFL, &enable, sizeof enable);
  if (::bind(socket_.get(), as_socket_address(&address.udp), sizeof address.udp) != 0) {
    fail_at_start(address.text + ": cannot be bound", errno);
  }
}

std::optional<Received> DatagramReceiver::next(std::span<std::uint8_t> into) {
  iovec place{.iov_base = into.data(), .iov_len = into.size()};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof dropped_) + CMSG_SPACE(sizeof(ucred))>
      beside{};
  msghdr message{};
  message.msg_iov = &place;
  message.msg_iovlen = 1;
  message.msg_control = beside.data();
  // A file that somebody sends along is closed by the system where there is no room for it beside:
  // only for options that this socket has set.
  message.msg_controllen = is_unix_ ? CMSG_SPACE(sizeof(ucred)) : CMSG_SPACE(sizeof dropped_);
  const ssize_t got = ::recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (got < 0) {
    return std::nullopt;  // an error of a sender (ECONNREFUSED) does not concern a receiver
  }
  Received received{.octets = static_cast<std::size_t>(got)};
  for (cmsghdr* control = CMSG_FIRSTHDR(&message); control != nullptr;
       control = CMSG_NXTHDR(&message, control)) {
    if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&dropped_, CMSG_DATA(control), sizeof dropped_);
    } else if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SCM_CREDENTIALS) {
      ucred sender{};
      std::memcpy(&sender, CMSG_DATA(control), sizeof sender);
      received.uid_known = true;
      received.uid = sender.uid;
    }
  }
  return received;
}

}  // namespace polhode::platform
