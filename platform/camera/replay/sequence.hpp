// An image sequence on disk (ASL layout): time stamps, image files and the camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "camera/replay/mosaic.hpp"
#include "camera/replay/sensor_yaml.hpp"
#include "pipeline/parameters.hpp"

namespace polhode::platform {

struct SequenceFrame {
  std::int64_t timestamp_ns = 0;
  std::string file;  ///< inside SEQ/mav0/cam0/data
};

/// The user's choices on the pixels.
struct PixelChoices {
  int depth_bits = 0;  ///< of 16-bit images, 8, 10, 12, 14 or 16; 0: as they are found
  MosaicChoice mosaic = MosaicChoice::kFind;
};

struct Sequence {
  std::filesystem::path path;
  std::filesystem::path image_folder;
  CameraParameters camera;
  std::vector<SequenceFrame> frames;  ///< at least one; time stamps strictly increasing
  int depth_bits = 16;                ///< of the levels in 16-bit images (depth.hpp)
  bool mosaic = false;                ///< one is to be taken out of the images (mosaic.hpp)
  std::size_t file_bytes_max = 0;  ///< of the frames' files, those beyond frame_bytes_max() aside
  std::size_t decoder_bytes = 0;   ///< as ImageHeader's, of the first image
  std::vector<std::string> warnings;  ///< likely mistakes, one line each with its file
};

/// A larger file is no frame of this camera: colour with alpha of 16 bits, stored raw, has 8 bytes
/// a pixel; one more for what a compressor adds to noise, and 1 MiB for profiles and remarks.
std::size_t frame_bytes_max(const CameraParameters& camera);

/// Content of the tables, without the images.
struct SequenceTables {
  Sensor sensor;
  std::vector<SequenceFrame> frames;  ///< as Sequence's
  std::vector<std::string> warnings;
};

/// Reads data.csv and sensor.yaml.
/// @throws UnusableInput as open_sequence() does for these.
SequenceTables read_tables(const std::filesystem::path& path, LensNeed need = LensNeed::kNumbers);

/// Reads data.csv and sensor.yaml, the first readable image header, and the sizes of all files, for
/// the plan of memory.
/// @throws UnusableInput naming the file and, where there is one, line and field: not a sequence,
/// no frames, a time stamp that repeats or runs back, stamps of another unit, an unusable camera,
/// images of another size.
Sequence open_sequence(const std::filesystem::path& path, const PixelChoices& choices = {});

}  // namespace polhode::platform
