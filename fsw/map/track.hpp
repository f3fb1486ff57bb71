// The pose of each frame from the map, checked against the predicted motion.
#pragma once

#include <cstddef>
#include <optional>

#include "geometry/pose_prediction.hpp"
#include "map/map_state.hpp"

namespace polhode {

inline constexpr std::size_t kPosesTried = 6;  ///< poses after which a motion counts as checked

/// 3 deg. A prediction with a more uncertain attitude is too weak for guided matching, and is no
/// substitute for a pose.
inline constexpr double kPredictionSigmaMost_rad = 0.05;

/// The pose predicted for this frame, and how far its motion has been checked.
struct ExpectedPose {
  PosePrediction prediction;
  double step_rad = 0.0;  ///< rotation from the last pose to it
  std::size_t poses_since_start =
      0;  ///< tracked one by one; an initialisation's poses have one common error
};

/// Allocates the memory of optical flow with the first image, and follows one point: later frames
/// then allocate nothing and cause no page faults.
void prepare_flow(const cv::Mat& gray, MapState* state);

/// Finds the pose by optical flow, where the image is predicted to move and the body to rotate by
/// little.
/// @return false where that is not so, or where the pose contradicts the motion so far.
bool follow_by_flow(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// Guided matching about the predicted pose, in a circle that grows when too few features agree. Of
/// poses that contradict the motion so far, the one with most inliers is kept for
/// overrule_motion().
bool find_about(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// As find_about(), while the last poses are inconsistent with the motion and no disturbance
/// hypothesis is accepted: a pose with under half of the last one's inliers does not confirm them.
bool find_about_inconsistent(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// Finds the pose from the few landmarks that agree with the predicted pose, and from that as a
/// prior: for a view with too few landmarks for a pose alone. Only where the motion has been
/// checked.
bool find_with_prior(const MapInput& input, const ExpectedPose& expected, MapState* state);

/// Takes the pose that find_about() has kept, where its inliers show that the motion is wrong: at
/// least kInliersAlone, at least half of the last pose's, and beyond chance more than those of
/// find_with_prior(), which has to be called before.
/// @param by_prior  the result of find_with_prior().
bool overrule_motion(const MapInput& input,
                     const ExpectedPose& expected,
                     bool by_prior,
                     MapState* state);

/// Finds the pose by descriptors alone, over all keyframes.
bool relocalise_frame(const MapInput& input, MapState* state);

/// Finds the pose by appearance where most descriptor matches are wrong, as in other light. It is
/// accepted only when the next frames confirm it.
bool recognise_frame(const MapInput& input, MapState* state);

/// Could the image show another face of the body as well, with no checked motion to decide? With
/// alike faces both poses are possible. The numbers of inliers do not decide: the visible face may
/// be the one with few landmarks. Only after relocalise_frame() has found a pose, which stays.
bool is_ambiguous(const MapInput& input,
                  const std::optional<ExpectedPose>& expected,
                  MapState* state);

/// Does this frame's pose agree with the motion so far? The bound has the prediction's sigma, and
/// some percent of the step for the error of the map's depth. For a motion that has hardly been
/// checked it is a degree and the change that Euler's equation allows (at most |w|^2 a second, so
/// a^2 for a step of a radians). An adjustment that has just moved the map adds its move.
/// @param initialisation_checks  an initialisation's poses count as checks. Where its map is
/// sheared all of them are off together, and refuse the first right one.
bool plausible(const ExpectedPose& expected, bool initialisation_checks, const MapState& state);

/// Does the pose rest on old landmarks of a revisited aspect? Then a jump of the pose is the drift
/// of the young landmarks, not the body's motion.
bool is_revisited(const MapState& state);

/// Is the aspect revisited, and the pose no further from the prediction than a contact could move
/// the body? A larger jump is no drift.
bool jumps_by_drift(const ExpectedPose& expected, const MapState& state);

/// Agrees with the motion, or is accepted without it for its inliers.
bool believable(const ExpectedPose& expected, bool initialisation_checks, const MapState& state);

/// Fuses this frame's pose with the prediction of a motion that was fitted together with the map.
/// Where one face of the body leaves a rotation uncertain, the motion constrains it. A measurement
/// that contradicts the prior is left as it is.
void fuse_with_prior(const PosePrediction& prior, MapState* state);

/// Marks this frame's pose as inconsistent with the motion, while no disturbance hypothesis is
/// decided: its covariance grows by the squared innovation.
void mark_inconsistent(const PosePrediction& predicted, MapState* state);

/// Matches this frame's features to a pose by flow, so that the frame can become a keyframe.
/// @return false, with the pose by flow as it was, where the features do not confirm it.
bool match_features(const MapInput& input,
                    const std::optional<PosePrediction>& prior,
                    MapState* state);

/// Counts for each landmark whether it should have been seen, and whether it was.
/// @param by_flow  flow finds only landmarks of its reference.
void count_observations(const CameraModel& camera, bool by_flow, MapState* state);

/// Makes this frame the reference of optical flow.
void renew_reference(std::uint32_t frame, MapState* state);

}  // namespace polhode
