#include "transport/command_ports.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <optional>

#include "../bus/command_packets.hpp"
#include "bus/octets.hpp"
#include "errors.hpp"
#include "packets.hpp"
#include "signed_commands.hpp"
#include "transport/transports.hpp"

namespace polhode::platform::command_ports_test {
namespace {

Octets cloud_request(std::uint32_t points) {
  return bus::command(bus::CommandCode::kRequestCloud,
                      bus::RequestCloudCommand{.points_max = points});
}

std::uint32_t points_of(std::span<const std::uint8_t> packet) {
  return static_cast<std::uint32_t>(
      bus::get_unsigned(packet, bus::request_cloud_layout::kPoints_max, 4));
}

class CommandPortsTest : public ::testing::Test {
 protected:
  [[nodiscard]] CommandPorts signed_ports(const std::vector<std::string>& addresses) const {
    return {addresses, signed_.settings(), SignedCommands::kUtc_ns};
  }

  Folder folder_;
  std::string unix_ = "unix:" + folder_ / "commands";
  std::string other_ = "unix:" + folder_ / "other";
  SignedCommands signed_;
};

TEST_F(CommandPortsTest, ArriveInOrder_NoMoreAtOnceThanAStepTakes) {
  Transports transports({.send = {}, .receive = {unix_}, .commands = {}});
  DatagramSender ground(parse_address(unix_));
  for (std::uint32_t i = 0; i < limits::kStepCommands + 2; ++i) {
    ground.send(cloud_request(i + 1));
  }
  const auto first = transports.received();
  ASSERT_EQ(first.size(), limits::kStepCommands);
  EXPECT_EQ(points_of(first[2]), 3U);
  EXPECT_EQ(transports.received().size(), 2U);
  EXPECT_TRUE(transports.received().empty());
  EXPECT_EQ(transports.commands().guard().counts().received, limits::kStepCommands + 2);
}

TEST_F(CommandPortsTest, LongerThanAnyPacketArriveTooLong_NotCutToFit) {
  CommandPorts ports({unix_}, {}, 0);
  const Descriptor ground(::socket(AF_UNIX, SOCK_DGRAM, 0));
  sockaddr_un to{.sun_family = AF_UNIX, .sun_path = {}};
  (folder_ / "commands").copy(to.sun_path, sizeof to.sun_path - 1);
  for (const std::size_t octets : {5000, 0}) {
    const Octets datagram(octets);
    ASSERT_EQ(
        ::sendto(
            ground.get(), datagram.data(), octets, 0, reinterpret_cast<sockaddr*>(&to), sizeof to),
        static_cast<ssize_t>(octets));
  }
  const auto packets = ports.receive();
  ASSERT_EQ(packets.size(), 2U);
  EXPECT_EQ(packets[0].size(), limits::kPacketOctets + 1);
  EXPECT_EQ(packets[1].size(), 0U);
}

TEST_F(CommandPortsTest, WithAKeyTakesSignedOnes_AsTheyWereBefore_OnEveryKindOfPort) {
  const std::string udp = "udp:39240";
  CommandPorts ports = signed_ports({unix_, udp});
  for (const std::string& address : {unix_, udp}) {
    DatagramSender ground(parse_address(address));
    ground.send(signed_.sign(cloud_request(7)));
    ground.send(cloud_request(8));
    const auto packets = ports.receive();
    ASSERT_EQ(packets.size(), 1U) << address;
    EXPECT_EQ(Octets(packets[0].begin(), packets[0].end()), cloud_request(7)) << address;
  }
  EXPECT_EQ(ports.guard().counts().passed, 2U);
  EXPECT_FALSE(ports.open_to_all());
}

// verifies: CMD-06
TEST_F(CommandPortsTest, UdpTakesUnsignedOnesOnlyWhereTheSettingsSayIt) {
  EXPECT_THROW(CommandPorts({"udp:39241"}, {}, 0), UnusableInput);
  EXPECT_THROW(CommandPorts({unix_, "udp:39241"}, {}, 0), UnusableInput);
  CommandSettings both = signed_.settings();
  both.unauthenticated = true;
  EXPECT_THROW(CommandPorts({unix_}, both, 0), UnusableInput);
  CommandSettings without_window = signed_.settings();
  without_window.window.clear();
  EXPECT_THROW(CommandPorts({unix_}, without_window, 0), UnusableInput);
  const CommandPorts open({"udp:39241"}, {.key = {}, .window = {}, .unauthenticated = true}, 0);
  EXPECT_TRUE(open.open_to_all());
  const CommandPorts closed({unix_}, {}, 0);
  EXPECT_FALSE(closed.open_to_all());
}

TEST_F(CommandPortsTest, AnotherUsersDatagramsAreRefused_WhateverTheModeOfTheFile) {
  if (::geteuid() != 0) {
    GTEST_SKIP() << "only root can become another user";
  }
  CommandPorts ports({unix_}, {}, 0);
  const std::string path = folder_ / "commands";
  ASSERT_EQ(::chmod(path.c_str(), 0666), 0);
  ASSERT_EQ(::chmod((folder_ / ".").c_str(), 0755), 0);
  const Octets packet = cloud_request(1);
  const pid_t child = ::fork();
  if (child == 0) {
    constexpr uid_t kNobody = 65534;
    const int fd = ::setuid(kNobody) == 0 ? ::socket(AF_UNIX, SOCK_DGRAM, 0) : -1;
    sockaddr_un to{.sun_family = AF_UNIX, .sun_path = {}};
    path.copy(to.sun_path, sizeof to.sun_path - 1);
    const ssize_t sent =
        ::sendto(fd, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
    ::_exit(sent == static_cast<ssize_t>(packet.size()) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0) << "the other user could not send";
  EXPECT_TRUE(ports.receive().empty());
  EXPECT_EQ(ports.guard().counts().refused_sender, 1U);
  DatagramSender own(parse_address(unix_));
  own.send(packet);
  EXPECT_EQ(ports.receive().size(), 1U);
}

// verifies: CMD-07
TEST_F(CommandPortsTest, AFloodAtOnePortStarvesNoneOfAnother_AndReadsABoundedNumber) {
  CommandPorts ports = signed_ports({"udp:39242", other_});
  DatagramSender flood(parse_address("udp:39242"));
  DatagramSender ground(parse_address(other_));
  for (std::uint32_t step = 0; step < 20; ++step) {
    for (std::size_t i = 0; i < 2 * CommandPorts::kReads; ++i) {
      flood.send(cloud_request(1));
    }
    ground.send(signed_.sign(cloud_request(step + 1)));
    const std::uint32_t before = ports.guard().counts().received;
    const auto packets = ports.receive();
    ASSERT_EQ(packets.size(), 1U) << step;
    EXPECT_EQ(points_of(packets[0]), step + 1);
    EXPECT_LE(ports.guard().counts().received - before, CommandPorts::kReads + 1);
  }
}

TEST_F(CommandPortsTest, WithoutAKeyAFloodLeavesOtherPortsTheirTurn) {
  CommandPorts ports({"udp:39243", other_}, {.key = {}, .window = {}, .unauthenticated = true}, 0);
  DatagramSender flood(parse_address("udp:39243"));
  DatagramSender ground(parse_address(other_));
  for (int i = 0; i < 100; ++i) {
    flood.send(Octets(20, 0xFF));
  }
  ground.send(cloud_request(5));
  ground.send(cloud_request(6));
  const auto packets = ports.receive();
  ASSERT_EQ(packets.size(), limits::kStepCommands);
  EXPECT_EQ(points_of(packets[1]), 5U);
  EXPECT_EQ(points_of(packets[3]), 6U);
}

}  // namespace
}  // namespace polhode::platform::command_ports_test
