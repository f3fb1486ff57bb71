// A camera that plays a sequence from disk, one frame a call.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "camera/replay/decode.hpp"
#include "camera/replay/mosaic.hpp"
#include "camera/replay/sequence.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

class FileCamera {
 public:
  /// Its buffers are acquired beside the pools: to be made before memory is sealed.
  /// @param sequence must outlive the camera.
  explicit FileCamera(const Sequence& sequence);

  /// The next frame; its image is valid until the next call. A file that is missing, truncated, of
  /// another size than the camera's or larger than is planned for comes as a frame that is not
  /// readable.
  /// @return false after the last frame.
  bool next(Frame& frame);

  /// The next frame handed out is the one of this index.
  void seek(std::size_t frame) { next_ = frame; }

  [[nodiscard]] std::size_t index() const { return next_ - 1; }  ///< of the frame handed out last
  [[nodiscard]] const std::string& refusal() const {
    return refusal_;
  }  ///< why that frame is not readable

  /// A remark on images that EXIF would turn, which is not done; empty: none.
  [[nodiscard]] std::string orientation_remark() const;

  /// A remark on images with levels beyond the depth, which are cut; empty: none.
  [[nodiscard]] std::string depth_remark() const;

  /// A remark on images of 8 bits a level among those of 16; empty: all are alike.
  [[nodiscard]] std::string mixed_remark() const;

 private:
  Refusal load(const SequenceFrame& frame);

  const Sequence& sequence_;
  std::size_t next_ = 0;
  std::vector<std::uint8_t> bytes_;
  DecodedImage image_;
  MosaicFilter mosaic_{0};
  std::string refusal_;
  std::size_t turned_ = 0;        ///< images with an orientation other than 1
  std::size_t first_turned_ = 0;  ///< the frame
  int orientation_ = 1;           ///< of that one
  std::size_t cut_ = 0;           ///< images with levels beyond the depth
  std::size_t shallow_ = 0;       ///< images of 8 bits a level
  std::size_t deep_ = 0;          ///< of 16
  std::size_t first_other_ = 0;   ///< the first frame of the second kind
};

}  // namespace polhode::platform
