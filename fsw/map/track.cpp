#include "map/track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "geometry/so3.hpp"
#include "map/recognise.hpp"

namespace polhode {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// (phi, dp) as in pose.hpp that takes `from` to `to`.
Vector6 difference(const Pose& to, const Pose& from) {
  Vector6 apart;
  apart << so3_log(to.R_CT * from.R_CT.transpose()), to.p_CT - from.p_CT;
  return apart;
}

constexpr double kDepthError = 0.05;  // of a map's depths: some percent

/// Fewer than kPosesTried poses have checked the motion.
/// @param initialisation_checks  the initialisation's poses count, too.
bool is_young(const ExpectedPose& expected, bool initialisation_checks) {
  return expected.prediction.rotation_poses < kPosesTried ||
         (!initialisation_checks && expected.poses_since_start < kPosesTried);
}

/// Builds the pyramids where they are missing. Most keyframes and frames are never followed by
/// flow, so they are not built in advance.
void ensure_pyramids(const cv::Mat& gray, MapState* s) {
  if (!s->reference.pyramid.built) {
    build_pyramid(s->reference.gray, &s->reference.pyramid);
  }
  build_pyramid(gray, &s->pyramid);
}

/// Enough inliers beyond chance. A mismatch within the smallest circle (4 px) falls within 4 sigma
/// (1 px) of its landmark by chance one time in 16; twice that many are beyond chance. The number
/// of landmarks that should be seen is no measure: a map has more of them than a frame features.
bool agrees(const LocalisedFrame& localised, int inliers_min) {
  constexpr int kByChance = 16 / 2;  // twice one in 16
  return localised.absolute.inliers >=
         inliers_min + static_cast<int>(localised.matches.size()) / kByChance;
}

/// Enough inliers, and few enough outliers, for a pose without the motion prior. Reflections in
/// foil that stay in place while the body rotates have supported wrong poses with half of the
/// matches; right poses on textured bodies have two thirds and more.
bool certain(const LocalisedFrame& localised) {
  return localised.absolute.inliers >= kInliersAlone &&
         5 * localised.absolute.inliers >= 3 * static_cast<int>(localised.matches.size());
}

/// A pose with under half the inliers of the last one. About a wrong prediction some matches agree
/// with a pose that lags behind the body. After a change of light even the right pose has no more.
bool is_thin(const LocalisedFrame& localised, const MapState& s) {
  return 2 * localised.absolute.inliers < s.before.inliers;
}

/// 1-sigma of the angle between two attitudes, worst axis.
double sigma_between(const PoseCovariance& one, const PoseCovariance& other) {
  return std::sqrt(one.topLeftCorner<3, 3>().diagonal().maxCoeff() +
                   other.topLeftCorner<3, 3>().diagonal().maxCoeff());
}

/// Could a contact within the last step explain the pose? It changes a body's rate, not its
/// attitude: a body stopped, reversed or made three times as fast is off by up to two steps. A
/// motion that has hardly been checked rules out nothing.
bool within_steps(const ExpectedPose& expected, const AbsolutePose& found, double moved_rad) {
  constexpr double kSteps = 2.0;  // from one step on to one step back
  const double bound_rad = (kSteps + kDepthError) * expected.step_rad +
                           4.0 * sigma_between(expected.prediction.covariance, found.covariance) +
                           moved_rad;
  return is_young(expected, false) ||
         rotation_angle_rad(found.pose.R_CT, expected.prediction.pose.R_CT) < bound_rad;
}

/// Could the body be here, with a push since the last pose? A slow body goes further than two of
/// its steps then. Alike faces are further apart, and so are most images of another time.
bool within_reach(const ExpectedPose& expected, const AbsolutePose& found, double moved_rad) {
  constexpr double kPushed_rad = 0.17;  // 10 deg from one frame to the next. Chosen
  return within_steps(expected, found, moved_rad) ||
         rotation_angle_rad(found.pose.R_CT, expected.prediction.pose.R_CT) < kPushed_rad;
}

/// The prediction, widened by the map's depth error times the step; nothing where its attitude is
/// too uncertain for matching.
std::optional<PosePrediction> tried_prior(const ExpectedPose& expected) {
  PosePrediction prior = expected.prediction;
  // A map's depth has an error of some percent, and so has a step (plausible()).
  widen_attitude(kDepthError * expected.step_rad, &prior.covariance);
  const double variance = prior.covariance.topLeftCorner<3, 3>().diagonal().maxCoeff();
  if (is_young(expected, false) ||
      !(variance < kPredictionSigmaMost_rad * kPredictionSigmaMost_rad)) {
    return std::nullopt;
  }
  return prior;
}

}  // namespace

void prepare_flow(const cv::Mat& gray, MapState* s) {
  if (!s->pyramid.levels.empty()) {
    return;
  }
  build_pyramid(gray, &s->pyramid);
  build_pyramid(gray, &s->reference.pyramid);
  const FlowPoint middle{.u_px = 0.5F * static_cast<float>(gray.cols),
                         .v_px = 0.5F * static_cast<float>(gray.rows)};
  FlowPoint found = middle;
  follow_points(s->pyramid, s->reference.pyramid, std::span(&middle, 1), {}, std::span(&found, 1));
  s->pyramid.built = s->reference.pyramid.built = false;
}

bool follow_by_flow(const MapInput& input, const ExpectedPose& expected, MapState* s) {
  // Edges slide along themselves; glints and background at the silhouette stay in place while the
  // body rotates. From a patch more than a degree old, flow finds poses that lag by up to 3 deg,
  // with all of a narrow face's landmarks in agreement. A keyframe comes later than a degree, and
  // needs features anyway.
  constexpr double kTurnMost_rad = 0.0175;
  const Pose& predicted = expected.prediction.pose;
  if (!s->reference.valid ||
      rotation_angle_rad(s->reference.pose.R_CT, predicted.R_CT) > kTurnMost_rad ||
      predicted_motion_px(s->reference, predicted, s->map, *input.camera) >
          input.tracks->small_motion_max_px) {
    return false;
  }
  ensure_pyramids(*input.gray, s);
  const Result<bool> done = localise_by_flow(localise_input(input, s->map),
                                             {&s->reference, &s->pyramid, input.tracks},
                                             predicted,
                                             &s->scratch.localise,
                                             &s->localised);
  const auto followed = static_cast<int>(s->reference.points.size());
  return done.ok() && 2 * s->localised.absolute.inliers >= followed &&
         plausible(expected, true, *s);
}

bool find_about(const MapInput& input, const ExpectedPose& expected, MapState* s) {
  const Pose& predicted = expected.prediction.pose;
  const double body_px = s->map.radius_mu * input.camera->focal_px() / predicted.p_CT.z();
  // The rotation between frames is predicted to about a tenth; three circles, each three times the
  // one before, cover the error.
  const double first_px = std::max(input.localise->search_floor_px, 0.04 * body_px);
  LocalisedFrame& best = s->scratch.other;
  best.absolute.inliers = 0;
  bool best_believable = false;
  // A pose that agrees with the initialisation, in any circle, comes before one that may contradict
  // it.
  for (const bool initialisation_checks : {true, false}) {
    if (!initialisation_checks && is_young(expected, true) == is_young(expected, false)) {
      break;  // nothing would differ
    }
    double radius_px = first_px;
    for (int i = 0; i < 3; ++i, radius_px *= 3.0) {
      const Result<bool> done = localise_guided(
          localise_input(input, s->map), predicted, radius_px, &s->scratch.localise, &s->localised);
      if (!done || !agrees(s->localised, input.localise->inliers_min)) {
        continue;
      }
      const bool fits = believable(expected, initialisation_checks, *s);
      if (fits && !is_thin(s->localised, *s)) {
        return true;
      }
      // Prefer candidates consistent with the predicted motion; among equals, the one with more
      // inliers. An inconsistent one wins only with more inliers beyond chance.
      const int inliers = s->localised.absolute.inliers;
      const bool better = fits == best_believable ? inliers > best.absolute.inliers
                          : fits                  ? !outnumbers(best.absolute.inliers, inliers)
                                                  : outnumbers(inliers, best.absolute.inliers);
      if (better) {
        best = s->localised;
        best_believable = fits;
      }
    }
  }
  if (best_believable) {
    take_matches(localise_input(input, s->map), best, &s->scratch.localise, &s->localised);
  }
  return best_believable;
}

bool find_about_inconsistent(const MapInput& input, const ExpectedPose& expected, MapState* s) {
  return find_about(input, expected, s) && !is_thin(s->localised, *s);
}

bool overrule_motion(const MapInput& input,
                     const ExpectedPose& expected,
                     bool by_prior,
                     MapState* s) {
  const LocalisedFrame& best = s->scratch.other;
  if (best.absolute.inliers < kInliersAlone || is_thin(best, *s) || !tried_prior(expected) ||
      !within_reach(expected, best.absolute, s->moved_rad) ||
      !outnumbers(best.absolute.inliers, by_prior ? s->localised.absolute.inliers : 0)) {
    return false;
  }
  take_matches(localise_input(input, s->map), best, &s->scratch.localise, &s->localised);
  return true;
}

bool find_with_prior(const MapInput& input, const ExpectedPose& expected, MapState* s) {
  const std::optional<PosePrediction> prior = tried_prior(expected);
  if (!prior) {
    return false;
  }
  const Result<bool> done = localise_with_prior(
      localise_input(input, s->map), *prior, &s->scratch.localise, &s->localised);
  return done && agrees(s->localised, kInliersWithPrior);
}

bool relocalise_frame(const MapInput& input, MapState* s) {
  const Result<bool> done =
      relocalise(localise_input(input, s->map), &s->scratch.localise, &s->localised);
  return done && s->localised.absolute.inliers >= kInliersAlone &&
         2 * s->localised.absolute.inliers >= static_cast<int>(s->localised.matches.size());
}

bool recognise_frame(const MapInput& input, MapState* s) {
  // As three frames that just have a pose each; foil and shadows make one, which the next denies.
  constexpr int kAgreeingMin = 3 * kAgreeingBlobsMin;
  constexpr int kFramesMin = 2;
  constexpr std::uint32_t kGapMax = 3;  // frames: after them the body has rotated too far
  const LocaliseInput localise = localise_input(input, s->map);
  RecognisedPose& last = s->before.recognised;
  const bool goes_on = last.frames > 0 && input.frame - last.frame <= kGapMax;
  const Result<int> agreeing =
      recognise(localise, goes_on ? &last.pose : nullptr, &s->scratch.localise, &s->localised);
  if (!agreeing) {
    return false;
  }
  const bool same = goes_on && is_same_aspect(s->localised.absolute.pose, last.pose);
  last = {.frames = same ? last.frames + 1 : 1,
          .agreeing = same ? last.agreeing + agreeing.value() : agreeing.value(),
          .frame = input.frame,
          .pose = s->localised.absolute.pose};
  s->localised.absolute.covariance = with_clutter(s->localised);
  return last.frames >= kFramesMin && last.agreeing >= kAgreeingMin;
}

bool is_ambiguous(const MapInput& input, const std::optional<ExpectedPose>& expected, MapState* s) {
  if (expected && !is_young(*expected, false) && plausible(*expected, false, *s)) {
    return false;
  }
  LocalisedFrame other;
  const LocaliseInput localise = localise_input(input, s->map);
  const AbsolutePose& found = s->localised.absolute;
  const Result<bool> done =
      relocalise_elsewhere(localise, found.pose, &s->scratch.localise, &other);
  const bool rival = done && agrees(other, input.localise->inliers_min) &&
                     rotation_angle_rad(found.pose.R_CT, other.absolute.pose.R_CT) >
                         4.0 * sigma_between(found.covariance, other.absolute.covariance);
  take_matches(
      localise, s->localised, &s->scratch.localise, &other);  // restores the scratch memory
  return rival;
}

bool is_revisited(const MapState& s) {
  int old = 0;
  int old_inliers = 0;
  for (const LandmarkMatch& match : s.localised.matches) {
    const Landmark& landmark = s.map.landmarks[match.landmark.index()];
    if (is_old(landmark, s.map)) {
      ++old;
      old_inliers += match.inlier ? 1 : 0;
    }
  }
  return old_inliers >= kInliersAlone && 2 * old_inliers >= old;
}

bool jumps_by_drift(const ExpectedPose& expected, const MapState& s) {
  return is_revisited(s) && within_steps(expected, s.localised.absolute, s.moved_rad);
}

bool plausible(const ExpectedPose& expected, bool initialisation_checks, const MapState& s) {
  constexpr std::size_t kPosesMin = 3;  // two poses give a rate without a check
  const PosePrediction& predicted = expected.prediction;
  if (predicted.rotation_poses < kPosesMin) {
    return true;
  }
  constexpr double kAllowance_rad = 0.0175;  // 1 deg
  const AbsolutePose& found = s.localised.absolute;
  const double step_rad = expected.step_rad;
  const double sigma_rad = sigma_between(predicted.covariance, found.covariance);
  const double bound_rad = is_young(expected, initialisation_checks)
                               ? step_rad * step_rad + 3.0 * sigma_rad + kAllowance_rad
                               : kDepthError * step_rad + 4.0 * sigma_rad;
  return rotation_angle_rad(found.pose.R_CT, predicted.pose.R_CT) < bound_rad + s.moved_rad;
}

bool believable(const ExpectedPose& expected, bool initialisation_checks, const MapState& s) {
  return plausible(expected, initialisation_checks, s) ||
         (within_reach(expected, s.localised.absolute, s.moved_rad) &&
          (is_revisited(s) || certain(s.localised)));
}

void fuse_with_prior(const PosePrediction& prior, MapState* s) {
  const AbsolutePose& measured = s->localised.absolute;
  const Vector6 apart = difference(measured.pose, prior.pose);
  const PoseCovariance sum = prior.covariance + measured.covariance;
  const Eigen::LDLT<PoseCovariance> factor(sum);
  constexpr double kChi2Max = 22.5;  // 99.9 % of six numbers
  if (factor.info() != Eigen::Success || !(apart.dot(factor.solve(apart)) < kChi2Max)) {
    return;
  }
  const PoseCovariance by_sum = factor.solve(prior.covariance);  // transposed gain
  const Vector6 step = by_sum.transpose() * apart;
  const PoseCovariance covariance = prior.covariance - by_sum.transpose() * prior.covariance;
  take_pose(
      {.R_CT = so3_exp(step.head<3>()) * prior.pose.R_CT, .p_CT = prior.pose.p_CT + step.tail<3>()},
      0.5 * (covariance + covariance.transpose()),
      &s->scratch.localise,
      &s->localised);
}

void mark_inconsistent(const PosePrediction& predicted, MapState* s) {
  const Vector6 apart = difference(s->localised.absolute.pose, predicted.pose);
  s->inconsistency = apart * apart.transpose();
}

bool match_features(const MapInput& input,
                    const std::optional<PosePrediction>& prior,
                    MapState* s) {
  LocalisedFrame& by_features = s->scratch.other;
  const Result<bool> done = localise_guided(localise_input(input, s->map),
                                            s->localised.absolute.pose,
                                            input.localise->search_floor_px,
                                            &s->scratch.localise,
                                            &by_features);
  if (!done || !agrees(by_features, input.localise->inliers_min)) {
    return false;
  }
  s->localised = by_features;
  if (prior) {
    fuse_with_prior(*prior, s);
  }
  return true;
}

void count_observations(const CameraModel& camera, bool by_flow, MapState* s) {
  for (const LandmarkMatch& match : s->localised.matches) {
    Landmark& landmark = s->map.landmarks[match.landmark.index()];
    landmark.predicted += by_flow ? 1 : 0;
    landmark.found += match.inlier ? 1 : 0;
  }
  if (by_flow) {
    return;
  }
  for (Landmark& landmark : s->map.landmarks) {
    Eigen::Vector2d pixel;
    if (landmark.used && should_be_seen(landmark, s->localised.absolute.pose, camera, &pixel)) {
      ++landmark.predicted;
    }
  }
}

void renew_reference(std::uint32_t frame, MapState* s) {
  s->reference.valid = true;
  s->reference.frame = frame;
  std::swap(s->reference.pyramid, s->pyramid);
  s->reference.gray_to_come = !s->reference.pyramid.built;
  s->reference.pose = s->localised.absolute.pose;
  s->reference.points.clear();
  for (const LandmarkMatch& match : s->localised.matches) {
    if (match.inlier && s->map.landmarks[match.landmark.index()].used) {
      (void)s->reference.points.push_back(match);
    }
  }
}

}  // namespace polhode
