// Small motion: the landmarks of the reference keyframe followed by optical flow straight from its
// image, so that no drift builds up between keyframes.
#pragma once

#include "map/localise.hpp"
#include "tracks/optical_flow.hpp"

namespace polhode {

/// The image that points are followed from, and the landmarks seen in it.
struct FlowReference {
  bool valid = false;
  cv::Mat gray;  ///< of which the pyramid is built when a frame is to be followed by flow
  bool gray_to_come =
      false;  ///< it is this step's image still, and is taken over when the next one comes
  Pyramid pyramid;
  std::uint32_t frame = 0;  ///< that it was taken from
  Pose pose;
  LandmarkMatches points;  ///< inliers of the frame
};

/// Median image motion of the reference's landmarks between its pose and `predicted`; large when
/// none stays in view.
double predicted_motion_px(const FlowReference& reference,
                           const Pose& predicted,
                           const Map& map,
                           const CameraModel& camera);

/// Follows the reference's points to the frame of `pyramid`, expected where `predicted` puts them,
/// and solves for the pose.
/// @errors TooFewObservations, NoConsensus, Degenerate.
Result<bool> localise_by_flow(const LocaliseInput& input,
                              const FlowReference& reference,
                              const Pyramid& pyramid,
                              const TrackOptions& options,
                              const Pose& predicted,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out);

}  // namespace polhode
