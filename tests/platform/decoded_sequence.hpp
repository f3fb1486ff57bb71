// A sequence played back and forth from memory: a long run that opens no file.
#pragma once

#include <cstdint>
#include <vector>

#include "camera/replay/file_camera.hpp"
#include "camera/replay/played_sequence.hpp"
#include "camera/replay/sequence.hpp"

namespace polhode::platform {

class DecodedSequence {
 public:
  /// @param sequence must outlive this object.
  explicit DecodedSequence(const Sequence& sequence) : sequence_(sequence) {
    FileCamera camera(sequence);
    Frame frame;
    while (camera.next(frame)) {
      std::vector<std::uint8_t>& rows = images_.emplace_back();
      for (int v = 0; v < frame.image.height_px; ++v) {
        const std::uint8_t* row = frame.image.data + v * frame.image.stride_bytes;
        rows.insert(rows.end(), row, row + frame.image.width_px);
      }
    }
  }

  /// @param position counts through all passes, as played_frame()'s; frames are 10 s apart.
  [[nodiscard]] Frame frame(std::size_t position) const {
    const CameraParameters& c = sequence_.camera;
    return {.timestamp_ns = static_cast<std::int64_t>(position + 1) * 10'000'000'000,
            .image = {.data = images_[played_frame(sequence_, position).index].data(),
                      .width_px = c.width_px,
                      .height_px = c.height_px,
                      .stride_bytes = c.width_px}};
  }

 private:
  const Sequence& sequence_;
  std::vector<std::vector<std::uint8_t>> images_;
};

}  // namespace polhode::platform
