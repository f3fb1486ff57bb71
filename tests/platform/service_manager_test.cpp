#include "os/linux/service_manager.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "listener.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::service_manager_test {
namespace {

class ServiceManagerTest : public testing::Test {
 protected:
  ServiceManagerTest() {
    ::setenv("NOTIFY_SOCKET", path_.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "4000000", 1);
    ::unsetenv("WATCHDOG_PID");
  }
  ~ServiceManagerTest() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  TemporaryFolder folder_;
  std::string path_ = (folder_.path() / "notify").string();
};

TEST_F(ServiceManagerTest, IsToldWhatHappens) {
  const Listener listener(path_);
  ServiceManager manager;
  manager.ready();
  EXPECT_EQ(listener.next(), "READY=1\nSTATUS=running");
  manager.status("TRACKING");
  EXPECT_EQ(listener.next(), "STATUS=TRACKING");
  manager.stopping();
  EXPECT_EQ(listener.next(), "STOPPING=1\nSTATUS=stopping");
}

TEST_F(ServiceManagerTest, TheWatchdogIsStrokedAtAQuarterOfItsTime) {
  const Listener listener(path_);
  ServiceManager manager;
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  EXPECT_EQ(manager.watchdog_ns(), 4 * kSecond_ns);
  manager.progress(10 * kSecond_ns);
  EXPECT_EQ(listener.next(), "WATCHDOG=1");
  manager.progress(10 * kSecond_ns + kSecond_ns / 2);
  EXPECT_EQ(listener.next(), "");
  manager.progress(11 * kSecond_ns);
  EXPECT_EQ(listener.next(), "WATCHDOG=1");
}

TEST_F(ServiceManagerTest, ALongStatusIsCutAndNothingIsWaitedFor) {
  ServiceManager manager;  // nobody listens
  manager.status(std::string(1000, 'x'));
  const Listener listener(path_);
  manager.status(std::string(1000, 'x'));
  EXPECT_EQ(listener.next(), "STATUS=" + std::string(248, 'x'));
}

TEST_F(ServiceManagerTest, AnotherProcessesWatchdogIsNotOurs) {
  ::setenv("WATCHDOG_PID", "1", 1);
  EXPECT_EQ(ServiceManager().watchdog_ns(), 0);
  ::unsetenv("WATCHDOG_PID");
}

TEST(ServiceManagerAlone, WithoutAManagerNothingHappens) {
  ::unsetenv("NOTIFY_SOCKET");
  ServiceManager manager;
  manager.ready();
  manager.progress(1);
  EXPECT_EQ(manager.watchdog_ns(), 0);
  ::setenv("NOTIFY_SOCKET", "relative", 1);  // not an address
  ServiceManager().ready();
  ::unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace polhode::platform::service_manager_test
