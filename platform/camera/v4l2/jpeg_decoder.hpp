// Decodes JPEG images of one size to gray, in memory that is taken at start: for a camera that
// delivers thirty compressed frames a second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace polhode::platform {

class JpegDecoder {
 public:
  /// Takes all memory that images of this size will need.
  JpegDecoder(int width_px, int height_px);
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
  JpegDecoder(JpegDecoder&&) = delete;
  JpegDecoder& operator=(JpegDecoder&&) = delete;

  /// @param gray   room for width times height.
  /// @return false when the bytes are no whole baseline JPEG image of this size (an image that
  /// ends early is refused, not filled with gray), or it needs more memory than such images do. The
  /// next image is decoded as usual. No heap.
  [[nodiscard]] bool decode(std::span<const std::uint8_t> bytes, std::uint8_t* gray);

  /// The most that an image has taken so far, of memory_bytes().
  [[nodiscard]] std::size_t peak_bytes() const;
  [[nodiscard]] std::size_t memory_bytes() const;

  struct State;  ///< the library's and ours; in the source file

 private:
  std::unique_ptr<State> state_;
};

}  // namespace polhode::platform
