#include "app/mask_log.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mask/mask_state.hpp"
#include "pipeline/ground_view.hpp"

namespace polhode::platform {
namespace {

constexpr unsigned char kTarget = 128;
constexpr unsigned char kOpen = 64;

const char* class_name(TrackClass kind) {
  switch (kind) {
    case TrackClass::kBackground:
      return "background";
    case TrackClass::kTarget:
      return "target";
    case TrackClass::kUnassigned:
      break;
  }
  return "unassigned";
}

/// Before black space the cells are the mask.
void draw(const GroundView& view, const cv::Size& size, std::vector<unsigned char>* pixels) {
  const cv::Mat& cells = view.mask.cells;
  const bool behind = view.mask_state.behind;
  pixels->resize(static_cast<std::size_t>(size.area()));
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const bool open = cells.at<std::uint8_t>(row * cells.rows / size.height,
                                               column * cells.cols / size.width) != 0;
      const bool target =
          behind ? view.mask_state.outline.at<std::uint8_t>(row, column) != 0 : open;
      (*pixels)[static_cast<std::size_t>(row * size.width + column)] =
          static_cast<unsigned char>((open ? kOpen : 0) + (target ? kTarget : 0));
    }
  }
}

}  // namespace

MaskLog::MaskLog(const std::filesystem::path& folder)
    : images_(folder / "masks.pgms"), tracks_(folder / "mask_tracks.csv") {
  tracks_.write("frame,u_px,v_px,from_u_px,from_v_px,class\n");
}

void MaskLog::append(std::size_t frame, const StepOutput& out, const GroundView& view) {
  const MaskState& mask = view.mask_state;
  const bool used = out.use == FrameUse::kUsed && !view.mask.cells.empty();
  const cv::Size size = !used         ? cv::Size(1, 1)
                        : mask.behind ? mask.outline.size()
                                      : view.mask.cells.size();
  if (used) {
    draw(view, size, &pixels_);
  } else {
    pixels_.assign(1, 0);
  }
  images_.write(fmt::format(
      "P5\n# frame {} used {:d} behind {:d} found {:d} sharp {:d} decimation {}\n{} {}\n255\n",
      frame,
      used,
      used && mask.behind,
      used && mask.found,
      used && mask.sharp,
      mask.behind ? mask.points.decimation : TargetMask::kCell_px,
      size.width,
      size.height));
  images_.write(pixels_.data(), pixels_.size());
  if (!used || !mask.behind) {
    return;
  }
  const auto full = static_cast<float>(mask.points.decimation);
  const auto pixel = [full](float working) { return (working + 0.5F) * full - 0.5F; };
  for (const MaskTrack& track : mask.points.tracks) {
    tracks_.write(fmt::format("{},{:.2f},{:.2f},{:.2f},{:.2f},{}\n",
                              frame,
                              pixel(track.now().x),
                              pixel(track.now().y),
                              pixel(track.places[track.count - 1].x),
                              pixel(track.places[track.count - 1].y),
                              class_name(track.kind)));
  }
}

void MaskLog::close() {
  images_.close();
  tracks_.close();
}

}  // namespace polhode::platform
