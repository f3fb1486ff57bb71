// The files of a recording: one after the other, each bounded, all of them together bounded, the
// oldest removed first.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace polhode::platform {

struct SegmentLimits {
  std::uint64_t segment_bytes_max = 0;
  std::uint64_t folder_bytes_max = 0;
};

/// "recording-<start of the run>-<number>.rec": in the order of their names they are in the order
/// of time.
class Segments {
 public:
  /// Reads the content of the folder, which is made if need be.
  /// @param run_utc_ns identifies this run's files.
  /// @throws RunFailure when the folder cannot be made or read.
  Segments(const std::filesystem::path& folder,
           std::int64_t run_utc_ns,
           const SegmentLimits& limits);
  ~Segments();
  Segments(const Segments&) = delete;
  Segments& operator=(const Segments&) = delete;

  /// True when `bytes` more would make the present file too long, or none is open.
  [[nodiscard]] bool wants_next(std::uint64_t bytes) const;
  /// Ends the present file and begins the next, making room for all of it first.
  /// @return false when it cannot be made.
  bool begin_next();
  /// The file just begun could not be: without its first record nobody can read it.
  void abandon_present();
  /// @return false when the disk did not take it.
  bool write(std::span<const std::uint8_t> bytes);

  [[nodiscard]] std::uint64_t folder_bytes() const { return folder_bytes_; }
  [[nodiscard]] std::uint32_t removed() const { return removed_; }

 private:
  using Name = std::array<char, 48>;
  struct Segment {
    Name name{};
    std::uint64_t bytes = 0;
  };
  void remove_oldest();

  std::filesystem::path folder_;
  std::int64_t run_utc_ns_;
  SegmentLimits limits_;
  int folder_descriptor_ = -1;
  int file_ = -1;
  std::uint32_t number_ = 0;
  std::vector<Segment> segments_;  ///< oldest first; room is made at the start
  std::uint64_t folder_bytes_ = 0;
  std::uint32_t removed_ = 0;
};

/// Files of a folder that are segments, in order of time.
std::vector<std::filesystem::path> segment_files(const std::filesystem::path& folder);

}  // namespace polhode::platform
