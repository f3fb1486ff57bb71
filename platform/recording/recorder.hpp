// Records the inputs of a run's packets: accepted frames, drops, commands, and the initial state.
// The frame's thread copies into a ring; another thread compresses and writes.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "os/linux/background_thread.hpp"
#include "os/linux/memory/table_memory.hpp"
#include "pipeline/component.hpp"
#include "recording/record.hpp"
#include "recording/segments.hpp"

namespace polhode::platform {

struct RecorderOptions {
  std::filesystem::path folder;
  std::int64_t run_utc_ns = 0;
  SegmentLimits limits;
  std::size_t slots = 8;
  bool complete = false;  ///< wait for the disk rather than miss a frame
};

struct RecorderCounters {
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;          ///< frames and commands for which no slot was free
  std::uint64_t write_failures = 0;  ///< records that the disk did not take
  std::uint64_t bytes = 0;
};

class Recorder {
 public:
  /// Needs of its images.
  static std::size_t bytes_needed(std::size_t slots, std::size_t frame_bytes_max);

  /// Takes all memory that it will need.
  /// @param begin the run's parameters, as text.
  /// @throws RunFailure when the folder cannot be used.
  Recorder(const RecorderOptions& options, std::string begin, std::size_t frame_bytes_max);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The state that the run starts from; before the first frame.
  void checkpoint(std::span<const std::uint8_t> bytes);
  void frame(const Frame& frame);
  void dropped(DropReason reason, std::uint32_t count);
  void command(std::span<const std::uint8_t> packet);

  [[nodiscard]] RecorderCounters counters();

 private:
  struct Slot {
    RecordHeader header;
    std::span<std::uint8_t> content;  ///< of its greatest size
  };

  enum class Patience : std::uint8_t { kNone, kShort, kEndless };
  /// The next free slot, if one comes in time.
  Slot* claim(Patience patience);
  /// As claim(), after missed records have been reported.
  Slot* claim_in_turn(Patience patience);
  void commit();
  void miss();
  static void work(void* recorder);
  void serve();
  void write_slot(Slot& slot);
  void compress(Slot& slot, std::span<const std::uint8_t>* content);
  /// Writes down how much the disk has refused. @return false while it refuses that, too.
  bool record_refused();
  /// As write_record(), after refused records have been reported.
  bool write_in_turn(const RecordHeader& header, std::span<const std::uint8_t> content);
  bool write_record(RecordHeader header, std::span<const std::uint8_t> content);

  bool complete_;
  std::string begin_;
  Segments segments_;
  std::vector<Slot> slots_;
  TableMemory memory_;  ///< of all images that wait, beside the pools, which are the libraries'
  std::span<std::uint8_t> differences_;
  std::span<std::uint8_t> compressed_;
  std::span<std::uint8_t> lz4_state_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t first_ = 0;  ///< filled slots: first_ .. first_ + filled_ - 1, round the ring
  std::size_t filled_ = 0;
  bool stop_ = false;
  std::uint32_t missed_since_ = 0;  ///< not yet written down
  std::uint32_t refused_ = 0;       ///< by the disk, not yet written down; the writing thread's
  RecorderCounters counters_;
  BackgroundThread thread_;
};

}  // namespace polhode::platform
