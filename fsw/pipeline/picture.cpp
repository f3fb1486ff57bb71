#include "pipeline/picture.hpp"

#include <algorithm>
#include <utility>

#include "bus/frame_uses.hpp"
#include "image/image.hpp"
#include "map/follow.hpp"
#include "map/localise.hpp"
#include "mask/behind.hpp"
#include "mask/follow.hpp"

namespace polhode {
namespace {

FrameUse use_of(const FrameVerdict& verdict) {
  const FrameFaultRow* const fault = row_of(verdict.fault);
  return verdict.decision == FrameDecision::kSkip && fault != nullptr ? fault->skipped
                                                                      : FrameUse::kUsed;
}

/// Pixels of the map's landmarks with this pose.
MaskPrior mask_prior(const Pose& pose,
                     const Map& map,
                     const CameraModel& camera,
                     PictureState* picture) {
  int proved = 0;
  for (const bool all : {false, true}) {
    picture->landmarks_px.clear();
    for (const Landmark& landmark : map.landmarks) {
      Eigen::Vector2d pixel;
      if (landmark.used && (all || confirmed(landmark)) &&
          should_be_seen(landmark, pose, camera, &pixel)) {
        (void)picture->landmarks_px.push_back(cv::Point2d(pixel.x(), pixel.y()));
        proved += all ? 0 : 1;
      }
    }
    if (proved >= kConfirmedAlone) {
      break;
    }
  }
  // The image bounds the radius of a body at close range.
  const double radius_px = map.radius_mu * camera.focal_px() / pose.p_CT.z();
  return {.points_px = picture->landmarks_px.view(),
          .radius_px = std::min(radius_px, static_cast<double>(limits::kImageSide))};
}

}  // namespace

void reset_pictures(PictureState* picture) {
  clear(&picture->mask_state);
  clear(&picture->quality);
}

FrameUse bring_picture(const Frame& frame,
                       const CameraModel& camera,
                       FlowReference* reference,
                       PictureState* picture) {
  if (!frame.readable || frame.image.data == nullptr) {
    return FrameUse::kUnreadable;
  }
  const cv::Size size(frame.image.width_px, frame.image.height_px);
  if (size != cv::Size(camera.width_px, camera.height_px) ||
      (picture->own != nullptr && size != picture->own->pixels.size())) {
    return FrameUse::kWrongSize;
  }
  if (std::exchange(reference->gray_to_come, false)) {
    std::swap(picture->gray, reference->gray);
  }
  import_frame(frame.image, &picture->gray);
  if (picture->own != nullptr) {
    blacken(*picture->own, &picture->gray);
  }
  return FrameUse::kUsed;
}

FrameUse judge_picture(const ImageOptions& options, PictureState* picture) {
  picture->verdict = assess(picture->gray, options, &picture->quality);
  return use_of(picture->verdict);
}

void look_for_target(const Pose* predicted,
                     const Map& map,
                     const CameraModel& camera,
                     const MaskOptions& options,
                     PictureState* picture) {
  find_target(picture->gray, options, &picture->mask);
  if (picture->own != nullptr) {
    close_cells(*picture->own, &picture->mask);
  }
  MaskPrior prior;
  if (predicted != nullptr && options.separates_background() &&
      border_is_lit(picture->mask.cells)) {
    prior = mask_prior(*predicted, map, camera, picture);
  }
  follow_target(picture->gray, prior, options, &picture->mask_state, &picture->mask);
  if (picture->own != nullptr) {
    leave_out(*picture->own, &picture->mask_state);
  }
}

}  // namespace polhode
