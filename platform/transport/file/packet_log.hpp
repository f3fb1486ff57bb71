// The packets of a live run, appended to one file step by step: packets published before a sudden
// end are in it, and a restarted run goes on at its end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "os/linux/descriptor.hpp"

namespace polhode::platform {

class PacketLog {
 public:
  /// A file of this user's own that nobody else may write to; no symbolic link is followed.
  /// @throws UnusableInput: it is none; RunFailure when it cannot be opened.
  explicit PacketLog(const std::filesystem::path& file);

  /// @return false when the disk did not take all of it; counted.
  bool append(std::span<const std::uint8_t> packets);

  [[nodiscard]] std::uint64_t octets() const { return octets_; }
  [[nodiscard]] std::uint32_t failures() const { return failures_; }

 private:
  Descriptor file_;
  std::uint64_t octets_ = 0;
  std::uint32_t failures_ = 0;
};

}  // namespace polhode::platform
