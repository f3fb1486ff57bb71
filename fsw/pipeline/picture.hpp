// The frame comes in: copied, judged, searched for the target.
#pragma once

#include <opencv2/core.hpp>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "image/quality.hpp"
#include "mask/mask_state.hpp"
#include "mask/options.hpp"
#include "mask/own_structure.hpp"
#include "mask/target_mask.hpp"
#include "pipeline/component.hpp"

namespace polhode {

struct CameraModel;
struct FlowReference;
struct Map;
struct Pose;

/// The state of the rooms image and mask: this frame's picture, and what is remembered of earlier
/// ones.
struct PictureState {
  cv::Mat gray;
  QualityHistory quality;
  FrameVerdict verdict;
  TargetMask mask;
  MaskState mask_state;
  const OwnStructure* own = nullptr;                          ///< the caller's; null: nothing is
  FixedVector<cv::Point2f, limits::kLandmarks> landmarks_px;  ///< where the map has them
};

/// Pictures are looked at anew, after a pause or for another target: none is compared with the ones
/// before.
void reset_pictures(PictureState* picture);

/// Imports the image alone; what is the servicer's own is black in it. @param reference  takes over
/// the picture that was in `gray`, where it still waits for it.
FrameUse bring_picture(const Frame& frame,
                       const CameraModel& camera,
                       FlowReference* reference,
                       PictureState* picture);

/// Judges the quality of an imported image.
FrameUse judge_picture(const ImageOptions& options, PictureState* picture);

/// Finds the target's mask; while a map is tracked and something may be behind it, with the
/// landmarks where the predicted pose has them.
/// @param predicted  nullptr: there is none, or no map is tracked.
void look_for_target(const Pose* predicted,
                     const Map& map,
                     const CameraModel& camera,
                     const MaskOptions& options,
                     PictureState* picture);

}  // namespace polhode
