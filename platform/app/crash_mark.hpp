// A run that crashes soon after its start leaves a mark, so that the next start does not begin
// where this one did.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

namespace polhode::platform {

/// Of crashes in a row, each within kFramesProven frames of its start.
struct CrashMark {
  /// Two starts from checkpoints, each with its crash; the next one is cold.
  static constexpr std::size_t kWarmMax = 2;

  std::uint32_t crashes = 0;
  std::array<std::uint32_t, kWarmMax> tried{};  ///< checksums of the checkpoints they began from

  [[nodiscard]] bool was_tried(std::uint32_t checksum) const;
};

/// Frames after which a start has succeeded: a later crash is not its fault.
inline constexpr std::uint32_t kFramesProven = 100;

/// The mark's file, beside a checkpoint.
std::filesystem::path crash_mark_file(const std::filesystem::path& checkpoint);

/// @return no crashes where there is no mark, or a damaged one.
CrashMark read_crash_mark(const std::filesystem::path& file);

/// As long as it lives, a crash leaves a mark: SIGSEGV, SIGBUS, SIGFPE, SIGILL, and SIGABRT, which
/// is also the service manager's answer to a hang. SIGKILL and loss of power leave none. One at a
/// time.
class CrashWatch {
 public:
  CrashWatch(const std::filesystem::path& checkpoint, const CrashMark& before);
  /// A run that has stepped and ends in order takes the mark away. One that ends by an exception,
  /// or before its first frame, leaves the mark as it was.
  ~CrashWatch();
  CrashWatch(const CrashWatch&) = delete;
  CrashWatch& operator=(const CrashWatch&) = delete;

  /// From now on a crash is laid to the checkpoint with this checksum; 0: to none, as at first.
  void begins_from(std::uint32_t checksum);
  /// A frame was stepped. After kFramesProven of them the mark goes, and none is left any more.
  void stepped();

 private:
  std::filesystem::path file_;
  CrashMark before_;
  std::uint32_t frames_ = 0;
};

/// The run is about to end by a fault of its own, though without a signal. Nothing without a
/// CrashWatch.
/// @return a mark was left: the start had not yet held for kFramesProven frames.
bool leave_crash_mark();

}  // namespace polhode::platform
