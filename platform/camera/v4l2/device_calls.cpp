#include "camera/v4l2/device_calls.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>

#include "os/linux/clock.hpp"

namespace polhode::platform {
namespace {

class LinuxDeviceCalls final : public DeviceCalls {
 public:
  int open(const char* path) override {
    const int device = ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return device < 0 ? -errno : device;
  }

  void close(int device) override { ::close(device); }

  int ioctl(int device, unsigned long request, void* argument) override {
    // A signal may interrupt the call; a device that always answers so is abandoned.
    constexpr int kTriesMax = 100;
    for (int i = 0; i < kTriesMax; ++i) {
      if (::ioctl(device, request, argument) >= 0) {
        return 0;
      }
      if (errno != EINTR) {
        return -errno;
      }
    }
    return -EINTR;
  }

  std::uint8_t* map(int device, std::size_t bytes, std::int64_t offset) override {
    void* block = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, device, offset);
    return block == MAP_FAILED ? nullptr : static_cast<std::uint8_t*>(block);
  }

  void unmap(std::uint8_t* block, std::size_t bytes) override { ::munmap(block, bytes); }

  int poll(int device, int timeout_ms) override {
    pollfd waited{.fd = device, .events = POLLIN, .revents = 0};
    const int ready = ::poll(&waited, 1, timeout_ms);
    if (ready < 0) {
      return errno == EINTR ? 0 : -errno;  // the caller looks at its stop request and comes again
    }
    return waited.revents;
  }

  std::int64_t now_ns() override { return clock_ns(CLOCK_MONOTONIC); }

  void sleep_ms(int duration_ms) override {
    const timespec duration{.tv_sec = duration_ms / 1000,
                            .tv_nsec = duration_ms % 1000 * 1'000'000};
    ::nanosleep(&duration, nullptr);  // a signal ends it early: the caller comes again
  }
};

}  // namespace

DeviceCalls& linux_device_calls() {
  static LinuxDeviceCalls calls;
  return calls;
}

}  // namespace polhode::platform
