#include "transport/datagram/datagram.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <fstream>

#include "errors.hpp"
#include "packets.hpp"
#include "transport/transports.hpp"

namespace polhode::platform::datagram_test {
namespace {

TEST(UnixDatagram, CarriesOnePacketEach_InOrder) {
  const Folder folder;
  const std::string address = "unix:" + folder / "telemetry";
  Reader reader(address);
  ASSERT_EQ(reader.opened(), 0);
  DatagramSender sender(parse_address(address));
  for (std::uint32_t i = 0; i < 5; ++i) {
    sender.send(motion_packet(i));
  }
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(reader.next(), motion_packet(i));
  }
  EXPECT_TRUE(reader.next().empty());
  EXPECT_EQ(sender.counts().sent, 5U);
}

TEST(UnixDatagram, HasAFileForItsOwnerAlone_ThatGoesWithTheReader) {
  const Folder folder;
  const std::string path = folder / "telemetry";
  struct stat status {};
  {
    const Reader reader("unix:" + path);
    ASSERT_EQ(::stat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U);
    const DatagramReceiver commands(parse_address("unix:" + folder / "commands"));
    ASSERT_EQ(::stat((folder / "commands").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U);
  }
  EXPECT_NE(::stat(path.c_str(), &status), 0);
  EXPECT_NE(::stat((folder / "commands").c_str(), &status), 0);
}

TEST(UnixDatagram, WithoutAReaderIsCounted_AndWorksOnceOneComes) {
  const Folder folder;
  const std::string address = "unix:" + folder / "telemetry";
  DatagramSender sender(parse_address(address));
  sender.send(motion_packet(0));
  EXPECT_EQ(sender.counts().no_reader, 1U);
  {
    Reader reader(address);
    sender.send(motion_packet(1));
    EXPECT_EQ(reader.next(), motion_packet(1));
  }
  sender.send(motion_packet(2));
  Reader again(address);
  sender.send(motion_packet(3));
  EXPECT_EQ(again.next(), motion_packet(3));
  EXPECT_EQ(sender.counts().sent, 2U);
  EXPECT_EQ(sender.counts().no_reader, 2U);
}

TEST(UnixDatagram, TakesThePlaceOfADeadReadersFile_ButNotOfALivingOnesNorOfAnotherFile) {
  const Folder folder;
  const std::string path = folder / "telemetry";
  {
    const Reader living("unix:" + path);
    EXPECT_EQ(Reader("unix:" + path).opened(), -EADDRINUSE);
    EXPECT_THROW(DatagramReceiver(parse_address("unix:" + path)), RunFailure);
  }
  // A reader that is killed leaves its file behind.
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  sockaddr_un to{.sun_family = AF_UNIX, .sun_path = {}};
  path.copy(to.sun_path, sizeof to.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  ::close(fd);
  EXPECT_EQ(Reader("unix:" + path).opened(), 0);
  const std::string file = folder / "notes.txt";
  std::ofstream(file) << "kept";
  EXPECT_EQ(Reader("unix:" + file).opened(), -EEXIST);
  EXPECT_THROW(DatagramReceiver(parse_address("unix:" + file)), UnusableInput);
  EXPECT_TRUE(std::ifstream(file).good());
}

TEST(UnixDatagram, AStoppedReaderLosesItsOwnPackets_AndNobodyElses) {
  const Folder folder;
  const std::string good = "unix:" + folder / "good";
  const std::string stopped = "unix:" + folder / "stopped";
  Reader reader(good);
  Reader never_reads(stopped);
  Transports transports({.send = {stopped, good}, .receive = {}});
  for (std::uint32_t i = 0; i < 2000; ++i) {
    transports.send(motion_packet(i));
    ASSERT_EQ(reader.next(), motion_packet(i));
  }
  EXPECT_EQ(reader.bus().missing, 0U);
  EXPECT_GT(transports.counts().dropped, 1000U);
  EXPECT_LE(transports.counts().sent + transports.counts().dropped, 4000U);
  EXPECT_GE(transports.counts().sent + transports.counts().dropped,
            4000U - DatagramSender::kBacklog);
}

TEST(UnixDatagram, ReaderThatIsLateGetsEverythingInOrder) {
  const Folder folder;
  const std::string address = "unix:" + folder / "telemetry";
  Reader reader(address);
  DatagramSender sender(parse_address(address));
  const std::uint32_t burst = 400;  // far more than the system's queue holds
  for (std::uint32_t i = 0; i < burst; ++i) {
    sender.send(motion_packet(i));
  }
  for (std::uint32_t i = 0; i < burst; ++i) {
    ASSERT_EQ(reader.next(), motion_packet(i));
    sender.flush();
  }
  EXPECT_EQ(sender.counts().dropped, 0U);
}

TEST(UnixDatagram, ReaderThatHasHeardTheSenderOnceIsHeldHundredsByTheSystem) {
  const Folder folder;
  const std::string address = "unix:" + folder / "telemetry";
  Reader reader(address);
  DatagramSender sender(parse_address(address), SenderName::kBesideReader);
  sender.send(motion_packet(0));
  ASSERT_EQ(reader.next(), motion_packet(0));
  const std::uint32_t burst = 150;
  for (std::uint32_t i = 1; i <= burst; ++i) {
    sender.send(motion_packet(i));
  }
  EXPECT_EQ(sender.counts().sent, burst + 1);  // nothing waits for another call
  for (std::uint32_t i = 1; i <= burst; ++i) {
    ASSERT_EQ(reader.next(), motion_packet(i));
  }
}

TEST(UnixDatagram, SendersFileIsItsOwnersAlone_AndGoesWithIt) {
  const Folder folder;
  const std::string file = folder / "telemetry.sender";
  struct stat status {};
  {
    Transports transports({.send = {"unix:" + folder / "telemetry"}, .receive = {}});
    ASSERT_EQ(::stat(file.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U);
    // A second sender to one reader has no name, and works.
    Reader reader("unix:" + folder / "telemetry");
    DatagramSender second(parse_address("unix:" + folder / "telemetry"), SenderName::kBesideReader);
    second.send(motion_packet(1));
    EXPECT_EQ(reader.next(), motion_packet(1));
  }
  EXPECT_NE(::stat(file.c_str(), &status), 0);
}

TEST(UnixDatagram, SenderThatDiesAndComesBackIsHeard_WithoutLoss) {
  const Folder folder;
  const std::string address = "unix:" + folder / "telemetry";
  Reader reader(address);
  {
    DatagramSender first(parse_address(address), SenderName::kBesideReader);
    first.send(motion_packet(0));
    ASSERT_EQ(reader.next(), motion_packet(0));
  }
  DatagramSender second(parse_address(address), SenderName::kBesideReader);
  std::uint32_t next = 1;
  for (std::uint32_t i = 1; i <= 40; ++i) {
    second.send(motion_packet(i));
    const Octets packet = reader.next(20);
    if (!packet.empty()) {
      ASSERT_EQ(packet, motion_packet(next++));
    }
  }
  second.flush();
  for (; next <= 40; ++next) {
    ASSERT_EQ(reader.next(20), motion_packet(next));
  }
  EXPECT_EQ(second.counts().sent, 40U);
}

TEST(UnixDatagram, GoesOnWithTheNextReader) {
  const Folder folder;
  const std::string address = "unix:" + folder / "telemetry";
  DatagramSender sender(parse_address(address));
  {
    const Reader never_reads(address);
    for (std::uint32_t i = 0; i < 100; ++i) {
      sender.send(motion_packet(i));
    }
  }
  Reader next_reader(address);
  sender.send(motion_packet(100));
  // What was meant for the first reader may still reach the second: in order, and the newest last.
  Octets last;
  for (Octets packet = next_reader.next(); !packet.empty(); packet = next_reader.next()) {
    last = packet;
    sender.flush();
  }
  EXPECT_EQ(last, motion_packet(100));
}

TEST(Udp, CarriesPacketsOverLoopback) {
  Reader reader("udp:39217");
  ASSERT_EQ(reader.opened(), 0);
  DatagramSender sender(parse_address("udp:39217"));
  sender.send(motion_packet(7));
  EXPECT_EQ(reader.next(1000), motion_packet(7));
}

}  // namespace
}  // namespace polhode::platform::datagram_test
