// Target masks frame by frame, for overlays and evaluation: written on request.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "output_file.hpp"
#include "pipeline/ground_view.hpp"

namespace polhode::platform {

/// masks.pgms: one binary PGM after the other, a frame each, reduced by the factor that its comment
/// names ("# frame 7 used 1 behind 1 found 1 sharp 0 decimation 2"). 128: target; plus 64: features
/// may be made there. mask_tracks.csv: points followed by the mask, with their class.
class MaskLog {
 public:
  explicit MaskLog(const std::filesystem::path& folder);
  void append(std::size_t frame, const StepOutput& out, const GroundView& view);
  void close();

 private:
  OutputFile images_;
  OutputFile tracks_;
  std::vector<unsigned char> pixels_;
};

}  // namespace polhode::platform
