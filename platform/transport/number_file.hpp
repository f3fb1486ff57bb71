// The greatest number of a command taken with each key, kept over restarts: a command captured
// before one is not taken after it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>

#include "os/linux/background_thread.hpp"
#include "os/linux/descriptor.hpp"
#include "transport/client/c/signing/polhode_sign.h"

namespace polhode::platform {

enum class Kept : std::uint8_t {
  kYes,      ///< it is in the file, whatever happens to the process, and the disk has it soon after
  kLate,     ///< not yet: disk or thread are slow
  kRefused,  ///< by the system
};

/// A small file with two places for each key, written in turn: a write that is torn leaves the
/// other whole. A thread of its own writes them.
class NumberFile {
 public:
  static constexpr std::size_t kKeys = 16;  // chosen: years of a key that changes with the seasons
  /// Longest wait for the thread. Chosen: long for 32 octets, short beside a frame.
  static constexpr std::chrono::milliseconds kWait{5};
  using WriteAt = ssize_t (*)(int, const void*, std::size_t, off_t);

  /// Begins with what is in the file. Of a key that was never in it nothing was captured, so its
  /// numbers begin at 0. A missing file, or a damaged place that may have been this key's, does not
  /// give the numbers taken: they then begin at the present, so that nothing signed before is.
  /// @param write  pwrite, but in tests.
  /// @throws UnusableInput: the file cannot be made or written by these settings, is another
  /// program's, or holds kKeys others; RunFailure: a fault of the disk.
  NumberFile(const std::filesystem::path& file,
             const polhode_key& key,
             std::uint64_t utc_ns,
             WriteAt write = ::pwrite);
  ~NumberFile();
  NumberFile(const NumberFile&) = delete;
  NumberFile& operator=(const NumberFile&) = delete;

  /// Where numbers begin.
  [[nodiscard]] std::uint64_t number() const { return number_; }
  /// Why there; empty when the file gave it.
  [[nodiscard]] const std::string& remark() const { return remark_; }

  /// Has the thread write it, and waits for that for at most kWait; not at all while the thread is
  /// late with an earlier one.
  Kept keep(std::uint64_t number);
  /// Of one that was handed to keep().
  Kept state_of(std::uint64_t number);

 private:
  struct Place;
  void begin(const std::filesystem::path& file, std::uint64_t utc_ns);
  /// Into the next of the two places. @return false when the system refused it.
  bool put(std::uint64_t number);
  [[nodiscard]] Kept state_with_lock(std::uint64_t number) const;
  static void work(void* numbers);
  void serve();

  WriteAt write_;
  Descriptor file_;
  std::uint64_t key_name_ = 0;
  std::uint64_t number_ = 0;
  std::size_t pair_ = 0;  ///< of places, in the file
  unsigned next_ = 0;     ///< place written next; the thread's
  std::string remark_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t wanted_ = 0;   ///< greatest handed to the thread
  std::uint64_t done_ = 0;     ///< greatest that the thread has tried
  std::uint64_t written_ = 0;  ///< greatest in the file
  bool stop_ = false;
  BackgroundThread thread_;
};

}  // namespace polhode::platform
