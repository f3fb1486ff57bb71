// Exports a recorded run as a sequence in the ASL layout, with all inputs that a replay needs for
// the same bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "recording/reader.hpp"

namespace polhode::platform {

struct ExportReport {
  std::uint64_t frames = 0;
  std::uint64_t unreadable = 0;  ///< of these: rows without a file
  std::uint64_t dropped = 0;     ///< by the live run, as it decided
  std::uint64_t not_recorded = 0;
  std::uint64_t commands = 0;
  std::uint64_t out_of_time =
      0;  ///< frames whose times do not increase: left out, as no sequence has such
  std::uint64_t bytes_lost = 0;
  std::uint32_t files_lost = 0;
  std::string own_structure_sha256 =
      {};  ///< of the image that mask.file named; it is not in the recording
  bool has_checkpoint = false;
  bool has_begin = false;  ///< else the replay starts where the recording does
};

/// Facts of a recorded run: TOML that a replay takes, and in comments what is not the
/// estimator's.
std::string begin_text(std::string_view version,
                       const std::string& own_structure_sha256,
                       const std::string& parameters);

/// Writes mav0/cam0/{data.csv, sensor.yaml, data/*.png}, config.toml, recording.json and, where the
/// run has them, checkpoint and commands.csv (timestamp_ns of the frame that follows, packet in
/// hexadecimal) into `folder`, which must not be there or be empty.
/// @throws UnusableInput, RunFailure.
ExportReport export_run(const RecordedRun& run, const std::filesystem::path& folder);

/// True when a replay of the export, as it is, gives the bytes of the live run.
bool replays_to_the_same_bytes(const ExportReport& report);

/// Losses of the recording, as in "41 bytes damaged, 2 frames not recorded"; else empty.
std::string losses_of(const ExportReport& report);

}  // namespace polhode::platform
