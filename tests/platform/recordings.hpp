// Recordings of made-up images.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/rng.hpp"
#include "recording/reader.hpp"
#include "recording/recorder.hpp"

namespace polhode::platform::recordings {

namespace fs = std::filesystem;

inline constexpr int kWidth = 64;
inline constexpr int kHeight = 48;
inline constexpr const char* kBegin =
    "# polhode\nseed = 1\ncamera.width_px = 64\ncamera.height_px = 48\ncamera.fu_px = 100.0\n"
    "camera.fv_px = 101.0\ncamera.cu_px = 31.5\ncamera.cv_px = 23.5\ncamera.k1 = 0.1\n"
    "camera.k2 = 0.0\ncamera.p1 = 0.0\ncamera.p2 = 0.0\n";

using Pixels = std::vector<std::uint8_t>;

/// Noise does not compress, a ramp does.
inline Pixels noise(std::uint64_t seed, std::size_t bytes) {
  Rng rng(seed, 1);
  Pixels pixels(bytes);
  for (std::uint8_t& pixel : pixels) {
    pixel = static_cast<std::uint8_t>(rng.below(256));
  }
  return pixels;
}

inline Pixels ramp(std::size_t bytes) {
  Pixels pixels(bytes);
  for (std::size_t i = 0; i < bytes; ++i) {
    pixels[i] = static_cast<std::uint8_t>(i / 7);
  }
  return pixels;
}

inline Frame frame_of(std::int64_t timestamp_ns,
                      const Pixels& pixels,
                      PixelFormat format = PixelFormat::kGray8) {
  return {.timestamp_ns = timestamp_ns,
          .image = {.data = pixels.data(),
                    .width_px = kWidth,
                    .height_px = kHeight,
                    .stride_bytes = format == PixelFormat::kGray16 ? 2 * kWidth : kWidth,
                    .format = format}};
}

inline RecorderOptions options(const fs::path& folder) {
  return {.folder = folder,
          .run_utc_ns = 1000,
          .limits = {.segment_bytes_max = 1'000'000, .folder_bytes_max = 10'000'000},
          .slots = 4,
          .complete = true};
}

inline constexpr std::size_t kFrameBytes = 2 * kWidth * kHeight;

inline std::vector<Record> read_all(const fs::path& folder, std::uint64_t* bytes_lost = nullptr) {
  const auto runs = recorded_runs(folder);
  RecordingReader reader(runs.back());
  std::vector<Record> records;
  Record record;
  while (reader.next(&record)) {
    records.push_back(record);
  }
  if (bytes_lost != nullptr) {
    *bytes_lost = reader.bytes_lost();
  }
  return records;
}

}  // namespace polhode::platform::recordings
