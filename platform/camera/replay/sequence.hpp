// An image sequence on disk (ASL layout): what was taken when, and by which camera.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

struct SequenceFrame {
  std::int64_t timestamp_ns = 0;
  std::string file;  ///< inside SEQ/mav0/cam0/data
};

struct Sequence {
  std::filesystem::path path;
  std::filesystem::path image_folder;
  CameraParameters camera;
  std::vector<SequenceFrame> frames;  ///< at least one; time stamps strictly increasing
};

/// Reads data.csv and sensor.yaml and looks at the first image that has a readable header.
/// @throws UnusableInput naming the file and, where there is one, line and field: not a sequence,
/// no frames, a time stamp that repeats or runs back, an unusable camera, images of another size.
Sequence open_sequence(const std::filesystem::path& path);

}  // namespace polhode::platform
