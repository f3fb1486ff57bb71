// The state of this room, kept from frame to frame.
#pragma once

#include <cstdint>

#include "geometry/camera_model.hpp"
#include "map/drift.hpp"
#include "map/follow.hpp"
#include "map/landmarks.hpp"
#include "map/localise.hpp"
#include "map/map.hpp"
#include "map/options.hpp"
#include "tracks/options.hpp"

namespace polhode {

/// Counts since they were last taken.
struct MapCounts {
  std::uint32_t tables_full = 0;
  std::uint32_t keyframes_inserted = 0;
  std::uint32_t keyframes_culled = 0;
  std::uint32_t landmarks_created = 0;
  std::uint32_t landmarks_culled = 0;
  std::uint32_t closures = 0;
};

/// Growth of the map while an adjustment was under way; the next adjustment covers it.
struct GrowthWaiting {
  bool any = false;
  bool closed = false;  ///< a loop closure, too
};

/// Size of the map at its last adjustment of all keyframes.
struct LastAdjustment {
  std::uint32_t keyframes = 0;
  std::uint32_t next_keyframe_number = 0;
};

/// State of recognise_frame() over successive frames.
struct RecognisedPose {
  int frames = 0;           ///< in succession with the same aspect; 0: none
  int agreeing = 0;         ///< blobs, in all of them
  std::uint32_t frame = 0;  ///< the last of them
  Pose pose;                ///< in it
};

/// Results of earlier frames.
struct PosesBefore {
  int inliers = 0;  ///< of the last pose by features
  RecognisedPose recognised;
  std::uint32_t looked_for = 0;  ///< frames in which a model's target was searched for, and not
                                 ///< recognised
};

/// Working memory; contents mean nothing between calls.
struct MapScratch {
  LocaliseScratch localise;
  CreateScratch create;
  LocalisedFrame other;  ///< a second set of matches beside the frame's: of a loop, of a trial
};

/// The state of this room.
struct MapState {
  Map map;
  MapDrift drift;
  std::uint32_t target_frame = 0;   ///< number of the map's frame T
  FlowReference reference;          ///< reference of optical flow
  Pyramid pyramid;                  ///< of this frame, once it is followed
  LocalisedFrame localised;         ///< this frame's pose and matches
  bool pose_valid = false;          ///< this frame has a pose
  bool pose_updates_motion = true;  ///< false: mostly the motion's prior, or a repeated pose
  PoseCovariance inconsistency =
      PoseCovariance::Zero();  ///< squared innovation of a suspect or repeated pose
  PosesBefore before;
  GrowthWaiting growth;
  LastAdjustment last_adjustment_of_all;
  double moved_rad = 0.0;  ///< by an adjustment taken in this step, under poses given before it
  MapCounts counts;
  MapScratch scratch;
};

/// A frame as input of this room, with its options. Pointers are never null.
struct MapInput {
  std::uint32_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude
  const cv::Mat* gray = nullptr;
  const Features* features = nullptr;  ///< empty until they are detected
  const CameraModel* camera = nullptr;
  ImageMotion image_motion = {};  ///< expected in this frame
  const LocaliseOptions* localise = nullptr;
  const TrackOptions* tracks = nullptr;
  const MapOptions* options = nullptr;
  std::size_t features_max = 0;  ///< of one frame
  std::uint64_t seed = 0;
};

/// Input of the localisation.
LocaliseInput localise_input(const MapInput& input, const Map& map);

/// Clears the last frame's results.
void begin_frame(MapState* state);

/// After a frame that was skipped or has no pose: the next one is not followed by flow.
void drop_reference(MapState* state);

/// Clears the map; T's number stays, and so do images that are still to come.
void reset_map(MapState* state);

}  // namespace polhode
