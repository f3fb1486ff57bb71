// Imports the frame, assesses its quality and finds the target's mask.
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

/// The state of the rooms image and mask: this frame's image, and the history of earlier ones.
struct PictureState {
  cv::Mat gray;
  QualityHistory quality;
  FrameVerdict verdict;
  TargetMask mask;
  MaskState mask_state;
  const OwnStructure* own = nullptr;                          ///< the caller's; null: nothing is
  FixedVector<cv::Point2f, limits::kLandmarks> landmarks_px;  ///< where the map has them
};

/// Resets the history of images, after a pause or for another target: the next one is not compared
/// with earlier ones.
void reset_pictures(PictureState* picture);

/// Imports the image alone; the servicer's own structure is black in it.
/// @param reference  takes the earlier image in `gray`, where it has not copied that yet.
FrameUse bring_picture(const Frame& frame,
                       const CameraModel& camera,
                       FlowReference* reference,
                       PictureState* picture);

/// Assesses the quality of an imported image.
FrameUse judge_picture(const ImageOptions& options, PictureState* picture);

/// Finds the target's mask. While a map is tracked before a lit background, landmarks at the
/// predicted pose are the prior.
/// @param predicted  nullptr: there is none, or no map is tracked.
void look_for_target(const Pose* predicted,
                     const Map& map,
                     const CameraModel& camera,
                     const MaskOptions& options,
                     PictureState* picture);

}  // namespace polhode
