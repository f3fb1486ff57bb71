// The pose of a frame from the map: guided matching about a predicted pose, or by descriptors
// alone.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/result.hpp"
#include "features/match.hpp"
#include "geometry/camera_model.hpp"
#include "geometry/image_motion.hpp"
#include "geometry/pose_prediction.hpp"
#include "map/map.hpp"
#include "map/options.hpp"
#include "solve/absolute_pose.hpp"
#include "tracks/options.hpp"

namespace polhode {

/// A feature of the frame that is matched to a landmark.
struct LandmarkMatch {
  LandmarkId landmark;
  std::int32_t feature = -1;  ///< index into the frame's features; -1: found by optical flow
  float u_px = 0.0F;          ///< distorted pixel
  float v_px = 0.0F;
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;
  bool inlier = false;
};

using LandmarkMatches = FixedVector<LandmarkMatch, limits::kPoseMatches>;

struct LocalisedFrame {
  AbsolutePose absolute;
  LandmarkMatches matches;
  int predicted = 0;  ///< landmarks that should be seen from this pose
};

/// The pose's covariance times matches over inliers. Outliers measure the clutter, a part of which
/// falls within the gate and biases the pose.
[[nodiscard]] PoseCovariance with_clutter(const LocalisedFrame& frame);

/// More inliers, beyond chance.
[[nodiscard]] inline bool outnumbers(int inliers, int others) {
  constexpr double kApart_sigmas = 3.0;  // 99.7 %, of a count with Poisson noise
  return inliers - others >= kApart_sigmas * std::sqrt(static_cast<double>(inliers));
}

/// Working memory of the functions below; contents mean nothing between calls.
struct LocaliseScratch {
  FeatureGrid grid;
  std::array<std::int32_t, limits::kFeatures> landmark_of_feature{};
  std::array<std::int32_t, limits::kFeatures> distance_of_feature{};
  FixedVector<PoseObservation, limits::kPoseMatches> observations;
  std::array<std::uint8_t, limits::kPoseMatches> inlier{};
};

/// Least inliers of a pose or loop that nothing else supports: alike faces of a body give chance
/// matches by the dozen (the least that a pose needs is 12).
inline constexpr int kInliersAlone = 30;

/// Least inliers that confirm a predicted pose: the prior gives its six unknowns, and three
/// observations determine a pose.
inline constexpr int kInliersWithPrior = 6;

/// Features this close are of one blob, in a search guided by a pose. Chosen: wider than that of
/// match_mutual, as of two blobs so close either may be the landmark's.
inline constexpr float kSamePlace_px = 2.0F;

/// Age of the landmarks that are matched.
enum class LandmarkAge : std::uint8_t {
  kAny,
  kOld,  ///< seen by none of the newest kRecentKeyframes keyframes: of a revisited aspect
};
/// Over this many keyframes, of 3 deg and more each, a body turns to another aspect.
inline constexpr std::uint32_t kRecentKeyframes = 15;

/// Between such a landmark and the newest keyframes there is drift: it is used only where its
/// aspect agrees as a whole.
inline bool is_old(const Landmark& landmark, const Map& map) {
  return map.next_keyframe_number - landmark.seen_keyframe > kRecentKeyframes;
}

struct LocaliseInput {
  const Map* map = nullptr;
  const Features* features = nullptr;
  const CameraModel* camera = nullptr;
  ImageMotion image_motion = {};  ///< expected in this frame
  const LocaliseOptions* options = nullptr;
  double ratio_max = 0.8;
  LandmarkAge age = LandmarkAge::kAny;
  std::uint64_t seed = 0;
  std::uint64_t stream = 0;  ///< differs from frame to frame
};

/// Is the landmark on a visible face, in front of the camera and inside the image?
bool should_be_seen(const Landmark& landmark,
                    const Pose& pose,
                    const CameraModel& camera,
                    Eigen::Vector2d* pixel);

/// Matches the landmarks of the requested age that should be seen, each to the feature most alike
/// within `radius_px` of its projection by `pose`. Fills `out->matches`, and `out->predicted` with
/// the number of these landmarks.
void match_about(const LocaliseInput& input,
                 const Pose& pose,
                 double radius_px,
                 LocaliseScratch* scratch,
                 LocalisedFrame* out);

/// Matches landmarks to features within `radius_px` of their projections by `predicted`, solves for
/// the pose, matches again about the result within its own covariance, and refines.
/// @errors TooFewObservations, NoConsensus, Degenerate.
Result<bool> localise_guided(const LocaliseInput& input,
                             const Pose& predicted,
                             double radius_px,
                             LocaliseScratch* scratch,
                             LocalisedFrame* out);

/// Solves for the pose from `out->matches` as they stand, by consensus (`hint` is tried first when
/// given), and marks the inliers.
/// @errors TooFewObservations, NoConsensus, Degenerate.
Result<bool> solve_matched(const LocaliseInput& input,
                           const Pose* hint,
                           LocaliseScratch* scratch,
                           LocalisedFrame* out);

/// Matches landmarks to features about a predicted pose, within its covariance, and solves for the
/// pose from matches and prior together: for views with too few landmarks for a pose by themselves.
/// @errors TooFewObservations, Degenerate.
Result<bool> localise_with_prior(const LocaliseInput& input,
                                 const PosePrediction& prior,
                                 LocaliseScratch* scratch,
                                 LocalisedFrame* out);

/// Solves for the pose from `out->matches` as they stand, by consensus, then matches again about it
/// and refines.
/// @errors as above.
Result<bool> localise_matched(const LocaliseInput& input,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out);

/// Matches features to the landmarks of all keyframes by nearest descriptors, then as
/// localise_matched.
/// @errors as above.
Result<bool> relocalise(const LocaliseInput& input, LocaliseScratch* scratch, LocalisedFrame* out);

/// As relocalise, where the features are matched only to landmarks that `found` does not show. On a
/// body with alike faces this is the pose that would have been found, had the other face not been
/// mapped.
/// @errors as above.
Result<bool> relocalise_elsewhere(const LocaliseInput& input,
                                  const Pose& found,
                                  LocaliseScratch* scratch,
                                  LocalisedFrame* out);

/// Restores the result of a frame that was solved before others.
void take_matches(const LocaliseInput& input,
                  const LocalisedFrame& frame,
                  LocaliseScratch* scratch,
                  LocalisedFrame* out);

/// Replaces the pose of the frame that was solved last, and classifies its matches again into
/// inliers and outliers.
void take_pose(const Pose& pose,
               const PoseCovariance& covariance,
               LocaliseScratch* scratch,
               LocalisedFrame* out);

}  // namespace polhode
