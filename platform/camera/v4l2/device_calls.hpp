// The calls that the driver makes to the kernel, behind a seam: tests put a device of their own
// there, with every fault that a real one can have.
#pragma once

#include <cstddef>
#include <cstdint>

namespace polhode::platform {

class DeviceCalls {
 public:
  virtual ~DeviceCalls() = default;

  /// Not blocking. @return a descriptor, or -errno; so are all results below.
  virtual int open(const char* path) = 0;
  virtual void close(int device) = 0;
  virtual int ioctl(int device, unsigned long request, void* argument) = 0;
  virtual std::uint8_t* map(int device, std::size_t bytes, std::int64_t offset) = 0;  ///< or null
  virtual void unmap(std::uint8_t* block, std::size_t bytes) = 0;
  /// @return the events that are ready; 0 when none came in time.
  virtual int poll(int device, int timeout_ms) = 0;
  virtual std::int64_t now_ns() = 0;  ///< CLOCK_MONOTONIC
  virtual void sleep_ms(int duration_ms) = 0;
};

/// The kernel's own. Stateless.
DeviceCalls& linux_device_calls();

}  // namespace polhode::platform
