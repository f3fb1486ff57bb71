// The pose of each frame from the map, with what the motion so far says of it.
#pragma once

#include <cstddef>
#include <optional>

#include "geometry/pose_prediction.hpp"
#include "map/map_state.hpp"

namespace polhode {

inline constexpr std::size_t kPosesTried = 6;  ///< that many poses have checked a motion

/// 3 deg. A prediction whose attitude is less known says too little of which feature is which, and
/// stands in for no pose.
inline constexpr double kPredictionSigmaMost_rad = 0.05;

/// The pose that the motion so far gives this frame, and how far that motion has been checked.
struct ExpectedPose {
  PosePrediction prediction;
  double step_rad = 0.0;  ///< turn from the last pose to it
  std::size_t poses_since_start =
      0;  ///< found one by one; those of an initialisation are right or wrong together
};

/// Draws the memory of optical flow with the first image, and follows a point once: a target that
/// first moves slowly later than that then asks for no memory, and misses no page.
void prepare_flow(const cv::Mat& gray, MapState* state);

/// By optical flow, where the image is expected to move and the body to turn by little.
/// @return false where that is not so, or where what it finds contradicts the motion so far.
bool follow_by_flow(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// Guided matching about the expected pose, in a circle that grows when too few features agree.
/// Of poses that contradict the motion so far the one with most inliers is kept for
/// overrule_motion().
bool find_about(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// The same about poses that departed from the motion: they have led to none yet, so that a pose
/// with under half of the last one's inliers does not bear them out.
bool find_about_inconsistent(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// By the few landmarks that agree with the expected pose, and by it: for a view that shows too few
/// for a pose of its own. Only where the motion behind it has been checked.
bool find_with_prior(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// The pose that find_about() has kept, where it is the motion that must err: it has as many
/// inliers as a pose needs that nothing supports, half of those of the last one, and beyond chance
/// more than the pose that the motion holds.
/// Only after find_with_prior() could have held one.
/// @param held  it has.
bool overrule_motion(const MapInput& input,
                     const ExpectedPose& expected,
                     bool by_prior,
                     MapState* state);

/// By descriptors alone, over all keyframes.
bool relocalise_frame(const MapInput& input, MapState* state);

/// By appearance where hardly any feature is the one that it is taken for, as in other light. A
/// pose that is found so is looked for again in the next frames, and is one when it is found there.
bool recognise_frame(const MapInput& input, MapState* state);

/// Does another side of the body explain the image, too, as well as a pose needs, and no motion
/// that has been checked tell which side it is? With alike faces one pose is as good as the other.
/// How many inliers each has says nothing: the face that is seen may be the one that is hardly
/// mapped. Only after relocalise_frame() has found a pose, which stays as it is.
bool is_ambiguous(const MapInput& input,
                  const std::optional<ExpectedPose>& expected,
                  MapState* state);

/// Does this frame's pose agree with the motion so far? The prediction knows its own error. A map's
/// depth is known to some percent, which falsifies a step by as much. A young motion has hardly
/// been checked: there the bound is what Euler's equation allows (the rate changes by at most |w|^2
/// a second, a step of a radians by a^2) and a degree. A map that has just been moved under its
/// poses leaves the prediction off by as much.
/// @param initialisation_checks  an initialisation's poses count as a check. Where its map is
/// sheared all of them are off together, and refuse the first right one.
bool plausible(const ExpectedPose& expected, bool initialisation_checks, const MapState& state);

/// An aspect has come back, and its old landmarks carry the pose: then the drift of the young ones,
/// not the body, has jumped.
bool is_revisited(const MapState& state);

/// It has come back, and the pose is no further from the motion than a contact could bring it: more
/// is no drift.
bool jumps_by_drift(const ExpectedPose& expected, const MapState& state);

/// Agrees with the motion, or is strong enough to be accepted without it.
bool believable(const ExpectedPose& expected, bool initialisation_checks, const MapState& state);

/// Combines this frame's pose with the pose by a motion that is known together with the map. Where
/// one face of the body shows little of a rotation, the motion knows the rest. A measurement that
/// contradicts the prior is left as it is.
void fuse_with_prior(const PosePrediction& prior, MapState* state);

/// This frame's pose departs from the motion so far, which has led to others, and nobody knows yet
/// which of the two is wrong: the pose is as uncertain as they differ.
void mark_inconsistent(const PosePrediction& predicted, MapState* state);

/// Gives a pose that was found by flow matches to this frame's features, so that it can become a
/// keyframe.
/// @return false, with the pose by flow as it was, where the features do not confirm it.
bool match_features(const MapInput& input,
                    const std::optional<PosePrediction>& prior,
                    MapState* state);

/// Counts for each landmark that it should have been seen, and whether it was.
/// @param by_flow  flow can find only what it followed.
void count_observations(const CameraModel& camera, bool by_flow, MapState* state);

/// Flow follows this frame from here on.
void renew_reference(std::uint32_t frame, MapState* state);

}  // namespace polhode
