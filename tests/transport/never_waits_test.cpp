// Publishing beside readers that do not read: the publishing thread never abandons its processor.
//
// The kernel counts how often a thread has waited for anything (voluntary switches). That count
// does not depend on how busy the machine is, as times do.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include "errors.hpp"
#include "packets.hpp"
#include "transport/datagram/datagram.hpp"
#include "transport/transports.hpp"

namespace polhode::platform::never_waits_test {
namespace {

/// How often this thread has waited so far.
long waits() {
  rusage use{};
  ::getrusage(RUSAGE_THREAD, &use);
  return use.ru_nvcsw;
}

/// Sends until nothing more fits, and once more. @return how often that made the thread wait.
long waits_of_full_queue(const std::string& path, bool may_wait) {
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const Descriptor sender(fd);
  const timeval patience{.tv_sec = 0, .tv_usec = 5000};
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  sockaddr_un to{.sun_family = AF_UNIX, .sun_path = {}};
  path.copy(to.sun_path, sizeof to.sun_path - 1);
  const Octets packet = motion_packet(0);
  const long before = waits();
  for (int i = 0; i < 5000; ++i) {
    if (::sendto(fd,
                 packet.data(),
                 packet.size(),
                 may_wait ? 0 : MSG_DONTWAIT,
                 reinterpret_cast<sockaddr*>(&to),
                 sizeof to) < 0) {
      break;
    }
  }
  return waits() - before;
}

TEST(Publishing, IsSeenToWaitWhereItDoes) {
  const Folder folder;
  const Reader stopped("unix:" + folder / "stopped");
  ASSERT_EQ(stopped.opened(), 0);
  EXPECT_EQ(waits_of_full_queue(folder / "stopped", false), 0);
  EXPECT_GT(waits_of_full_queue(folder / "stopped", true), 0);
}

/// Everything that a reader may do to a sender, short of reading well, and a good one of each kind.
struct Audience {
  explicit Audience(const Folder& folder)
      : shared_name("/polhode_never_" + std::to_string(::getpid())),
        pipe_path(folder / "pipe"),
        good("unix:" + folder / "good"),
        stopped("unix:" + folder / "stopped"),
        udp_stopped("udp:39231") {
    {
      const Reader dead("unix:" + folder / "dead");
      ::link((folder / "dead").c_str(), (folder / "left_behind").c_str());
    }
    EXPECT_EQ(::mkfifo(pipe_path.c_str(), 0600), 0);
    pipe_end = Descriptor(::open(pipe_path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    addresses = {"unix:" + folder / "stopped",
                 "unix:" + folder / "left_behind",
                 "unix:" + folder / "nobody",
                 "udp:39231",
                 "udp:39232",  // nobody
                 "shm:" + shared_name,
                 "file:" + pipe_path,
                 "unix:" + folder / "good"};
  }
  ~Audience() { ::shm_unlink(shared_name.c_str()); }
  Audience(const Audience&) = delete;
  Audience& operator=(const Audience&) = delete;

  std::string shared_name;
  std::string pipe_path;
  Reader good;
  Reader stopped;
  Reader udp_stopped;
  Descriptor pipe_end;  ///< never read from
  std::vector<std::string> addresses;
};

// verifies: LIV-07
TEST(Publishing, NeverWaits_WhateverItsReadersDo) {
  const Folder folder;
  Audience audience(folder);
  Transports transports({.send = audience.addresses, .receive = {}});
  Reader ring(std::string("shm:") + audience.shared_name);
  const Reader ring_stopped(std::string("shm:") + audience.shared_name);
  ASSERT_EQ(ring.opened(), 0);
  const std::uint32_t total = 5000;
  std::vector<Octets> packets;
  for (std::uint32_t i = 0; i < total; ++i) {
    packets.push_back(motion_packet(i));
  }
  long waited = 0;
  std::uint32_t heard = 0;
  for (const Octets& packet : packets) {
    const long before = waits();
    transports.send(packet);
    waited += waits() - before;
    heard += audience.good.next() == packet && ring.next() == packet ? 1 : 0;
  }
  EXPECT_EQ(waited, 0);
  EXPECT_EQ(heard, total);
  // Nothing of this was easy: the stopped readers' queues and the pipe were full, and two were not
  // there.
  EXPECT_GT(transports.counts(0).dropped, total / 2);
  EXPECT_EQ(transports.counts(1).no_reader, total);
  EXPECT_EQ(transports.counts(2).no_reader, total);
  EXPECT_GT(transports.counts(6).dropped, total / 2);
}

TEST(Publishing, ToAReaderThatComesBackSendsFewOfThoseThatWaitedAtATime) {
  const Folder folder;
  const std::string address = "unix:" + folder / "late";
  Reader reader(address);
  DatagramSender sender(parse_address(address));
  std::uint32_t sent = 0;
  const auto wait_in_line = [&] { return sent - sender.counts().sent; };
  for (; wait_in_line() < 300; ++sent) {
    sender.send(motion_packet(sent));
  }
  std::uint32_t heard = 0;
  while (wait_in_line() > 0) {
    for (Octets packet = reader.next(); !packet.empty(); packet = reader.next()) {
      ASSERT_EQ(packet, motion_packet(heard++));
    }
    const std::uint64_t before = sender.counts().sent;
    sender.send(motion_packet(sent++));
    ASSERT_LE(sender.counts().sent - before, DatagramSender::kRetries + 1);
    ASSERT_GT(sender.counts().sent, before);
  }
  EXPECT_EQ(sender.counts().dropped, 0U);
}

TEST(FlatFile, InAPipeIsWholePackets_AndRefusedWithoutAReader) {
  const Folder folder;
  const std::string path = folder / "pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_THROW(Transports({.send = {"file:" + path}, .receive = {}}), UnusableInput);
  const Descriptor end(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  Transports transports({.send = {"file:" + path}, .receive = {}});
  const std::uint32_t total = 1000;  // more than a pipe's 64 KiB
  for (std::uint32_t i = 0; i < total; ++i) {
    transports.send(motion_packet(i));
  }
  EXPECT_EQ(transports.counts().sent + transports.counts().dropped, total);
  Octets packet(kMotionPacketOctets);
  std::uint32_t whole = 0;
  while (::read(end.get(), packet.data(), packet.size()) == static_cast<ssize_t>(packet.size())) {
    ASSERT_EQ(packet, motion_packet(whole++));
  }
  EXPECT_EQ(whole, transports.counts().sent);
}

}  // namespace
}  // namespace polhode::platform::never_waits_test
