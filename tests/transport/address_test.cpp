#include "transport/address.hpp"

#include <gtest/gtest.h>

#include "errors.hpp"

namespace polhode::platform::address_test {
namespace {

TEST(Address, OfUdpIsLoopbackUnlessAHostIsGiven) {
  EXPECT_EQ(parse_address("udp:10015").udp.sin_addr.s_addr, htonl(INADDR_LOOPBACK));
  EXPECT_EQ(parse_address("udp:10015").udp.sin_port, htons(10015));
  EXPECT_EQ(parse_address("udp:10.1.2.3:99").udp.sin_addr.s_addr, htonl(0x0A010203));
}

TEST(Address, NamesItsKindAndPlace) {
  EXPECT_EQ(parse_address("unix:/run/a:b").path, "/run/a:b");
  EXPECT_EQ(parse_address("unix:/run/a:b").kind, AddressKind::kUnix);
  EXPECT_EQ(parse_address("shm:/polhode").kind, AddressKind::kShm);
  EXPECT_EQ(parse_address("file:flight.ccsds").path, "flight.ccsds");
}

TEST(Address, ThatIsNoneIsRefused) {
  const std::string long_path = "unix:/" + std::string(200, 'x');
  for (const std::string& text : {std::string(),
                                  std::string("unix"),
                                  std::string("unix:"),
                                  std::string("tcp:80"),
                                  std::string("udp:0"),
                                  std::string("udp:70000"),
                                  std::string("udp:12x"),
                                  std::string("udp:localhost:80"),
                                  std::string("udp:1.2.3:80"),
                                  std::string("shm:polhode"),
                                  std::string("shm:/a/b"),
                                  std::string("shm:/"),
                                  long_path}) {
    EXPECT_THROW(parse_address(text), UnusableInput) << text;
  }
}

}  // namespace
}  // namespace polhode::platform::address_test
