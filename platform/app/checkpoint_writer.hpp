// Checkpoints of a live run, written by a thread of their own: the frame loop only copies.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>

#include "app/checkpoint_file.hpp"
#include "os/linux/background_thread.hpp"
#include "os/linux/memory/table_memory.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::platform {

struct CheckpointCounters {
  std::uint32_t written = 0;
  std::uint32_t failed = 0;  ///< the disk did not take it
  std::uint32_t skipped =
      0;  ///< the one before was still being written, or the state was damaged in memory
  std::uint64_t bytes = 0;  ///< of the last
};

class CheckpointWriter {
 public:
  /// @param restarts written with every state
  /// @param key signs every state; empty: none is signed
  CheckpointWriter(const std::filesystem::path& file,
                   const CheckpointIdentity& identity,
                   std::uint32_t restarts = 0,
                   const std::optional<polhode_key>& key = {});
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  /// Copies the state and returns; nothing when the last one is still being written.
  /// @param stepped when its last frame was stepped: from then on it ages.
  void offer(const Component& component, const Moment& stepped);
  /// As offer(), but waits until it is on the disk; it may be there already. For the end of a run.
  void write_now(const Component& component, const Moment& stepped);

  [[nodiscard]] CheckpointCounters counters();

 private:
  static void work(void* writer);
  void serve();

  CheckpointPlaces places_;
  std::optional<polhode_key> key_;
  CheckpointStamp stamp_;           ///< of the thread while `waiting_`
  TableMemory memory_;              ///< beside the pools, which are the libraries'
  std::span<std::uint8_t> buffer_;  ///< of the thread while `waiting_`
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t waiting_ = 0;                 ///< bytes to be written; 0: none
  std::int64_t written_since_boot_ns_ = 0;  ///< that the last one on the disk was stepped at
  bool stop_ = false;
  CheckpointCounters counters_;
  BackgroundThread thread_;
};

/// CLOCK_REALTIME.
std::int64_t utc_now_ns();

}  // namespace polhode::platform
