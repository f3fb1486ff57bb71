// Small motion: follows the landmarks of the reference keyframe by optical flow directly from its
// image, so that no drift builds up between keyframes.
#pragma once

#include "map/localise.hpp"
#include "tracks/optical_flow.hpp"

namespace polhode {

/// The image from which points are followed, and the landmarks seen in it.
struct FlowReference {
  bool valid = false;
  cv::Mat gray;               ///< the pyramid is built when a frame is to be followed
  bool gray_to_come = false;  ///< the image is this step's; it is copied when the next one comes
  Pyramid pyramid;
  std::uint32_t frame = 0;  ///< of the image
  Pose pose;
  LandmarkMatches points;  ///< inliers of the frame
};

/// From where to where points are followed, and how. Pointers are never null.
struct FlowPair {
  const FlowReference* reference = nullptr;
  const Pyramid* pyramid = nullptr;  ///< of this frame
  const TrackOptions* options = nullptr;
};

/// Median image motion of the reference's landmarks between its pose and `predicted`; large when
/// none stays in view.
double predicted_motion_px(const FlowReference& reference,
                           const Pose& predicted,
                           const Map& map,
                           const CameraModel& camera);

/// Follows the reference's points to this frame, from their projections by `predicted`, and solves
/// for the pose.
/// @errors TooFewObservations, NoConsensus, Degenerate.
Result<bool> localise_by_flow(const LocaliseInput& input,
                              const FlowPair& flow,
                              const Pose& predicted,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out);

}  // namespace polhode
