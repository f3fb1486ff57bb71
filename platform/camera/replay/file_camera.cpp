#include "camera/replay/file_camera.hpp"

#include <fmt/format.h>

#include "camera/replay/depth.hpp"
#include "camera/replay/exif.hpp"
#include "camera/replay/file_bytes.hpp"
#include "os/linux/memory/region.hpp"
#include "quote.hpp"

namespace polhode::platform {
namespace {

constexpr std::size_t kRowBytes = 6;  // a pixel of colour, 16 bits each

}  // namespace

FileCamera::FileCamera(const Sequence& sequence) : sequence_(sequence) {
  const BesideScope scope;
  const auto width = static_cast<std::size_t>(sequence.camera.width_px);
  const auto height = static_cast<std::size_t>(sequence.camera.height_px);
  image_.pixels.reserve(2 * width * height);  // 16 bits: no frame of this camera needs more
  image_.scratch.reserve(kRowBytes * width);
  bytes_.reserve(sequence.file_bytes_max);
  mosaic_ = MosaicFilter(sequence.mosaic ? sequence.camera.width_px : 0);
}

Refusal FileCamera::load(const SequenceFrame& frame) {
  if (Refusal refusal =
          read_file(sequence_.image_folder / frame.file, bytes_, sequence_.file_bytes_max)) {
    return refusal;
  }
  ImageHeader header;
  if (Refusal refusal = read_header(bytes_, header)) {
    return refusal;
  }
  const CameraParameters& camera = sequence_.camera;
  if (header.width_px != camera.width_px || header.height_px != camera.height_px) {
    return fmt::format("image is {}x{}, but sensor.yaml says resolution: [{}, {}]",
                       header.width_px,
                       header.height_px,
                       camera.width_px,
                       camera.height_px);
  }
  if (header.decoder_bytes > sequence_.decoder_bytes) {
    return "JPEG: in several scans, other than the first image; no memory is planned for that";
  }
  if (Refusal refusal = decode(bytes_, image_)) {
    return refusal;
  }
  const bool mixed_before = shallow_ > 0 && deep_ > 0;
  ++(header.format == PixelFormat::kGray16 ? deep_ : shallow_);
  if (!mixed_before && shallow_ > 0 && deep_ > 0) {
    first_other_ = index();
  }
  const int orientation = exif_orientation(bytes_);
  if (orientation != 1 && ++turned_ == 1) {
    first_turned_ = index();
    orientation_ = orientation;
  }
  cut_ += scale_up(sequence_.depth_bits, &image_) ? 0 : 1;
  if (sequence_.mosaic) {
    mosaic_.level(&image_);
  }
  return std::nullopt;
}

std::string FileCamera::orientation_remark() const {
  if (turned_ == 0) {
    return {};
  }
  return fmt::format(
      "{}: {} of {} pictures have an EXIF orientation other than 1 ({}: {}); their pixels are "
      "taken "
      "as stored",
      sequence_.image_folder.string(),
      turned_,
      sequence_.frames.size(),
      cited(sequence_.frames[first_turned_].file),
      orientation_);
}

std::string FileCamera::depth_remark() const {
  if (cut_ == 0) {
    return {};
  }
  return fmt::format(
      "{}: {} of {} pictures hold levels beyond the {} bits that were taken for their depth; "
      "these "
      "are cut (--depth-bits says other)",
      sequence_.image_folder.string(),
      cut_,
      sequence_.frames.size(),
      sequence_.depth_bits);
}

std::string FileCamera::mixed_remark() const {
  if (shallow_ == 0 || deep_ == 0) {
    return {};
  }
  return fmt::format(
      "{}: {} pictures have 8 bits a level, {} have 16 (the first that differs: {}); each kind is "
      "taken to fill its own scale, which changes the brightness where that is wrong",
      sequence_.image_folder.string(),
      shallow_,
      deep_,
      cited(sequence_.frames[first_other_].file));
}

bool FileCamera::next(Frame& frame) {
  if (next_ >= sequence_.frames.size()) {
    return false;
  }
  const SequenceFrame& entry = sequence_.frames[next_++];
  const Refusal refusal = load(entry);
  refusal_ = refusal ? cited(entry.file) + ": " + *refusal : std::string();
  frame = {.timestamp_ns = entry.timestamp_ns,
           .image = refusal ? ImageView{} : image_.view(),
           .readable = !refusal};
  return true;
}

}  // namespace polhode::platform
