// The problem of an initialisation, its outcome and its workspace.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/pose.hpp"
#include "initialisation/hypothesis.hpp"
#include "solve/initial_adjustment.hpp"

namespace polhode {

struct InitialObservation {
  int frame = 0;                                       ///< index into times_s
  PackedVector2d normalised = PackedVector2d::Zero();  ///< undistorted, on the plane z = 1
  double sigma_normalised = 1.0;                       ///< 1-sigma of each coordinate
};

struct InitialTrack {
  FixedVector<InitialObservation, limits::kInitialFrames>
      observations;  ///< ordered by frame, one per frame
};

/// nullptr where there is none.
inline const InitialObservation* find_frame(const InitialTrack& track, int frame) {
  const auto* const at = std::find_if(
      track.observations.begin(), track.observations.end(), [frame](const InitialObservation& o) {
        return o.frame == frame;
      });
  return at == track.observations.end() ? nullptr : at;
}

struct InitialProblem {
  std::span<const double> times_s;  ///< of F <= kInitialFrames frames, ascending
  std::span<const Eigen::Matrix3d> R_IC =
      {};                                ///< the observer's attitudes; empty: it does not rotate
  std::span<const InitialTrack> tracks;  ///< at most kInitialTracks
  std::uint64_t seed = 0;
  std::uint32_t kinds = kAllKinds;  ///< kinds of hypotheses that are made
};

enum class InitialDecision : std::uint8_t {
  kCommit,
  kTooFewTracks,     ///< no three frames have enough tracks in common
  kNoHypothesis,     ///< nothing rigid explains most of the images
  kTooLittleMotion,  ///< the winner's depth is not determined
  kMarginTooSmall,   ///< a geometrically different hypothesis fits nearly as well
};

struct InitialFramePose {
  bool valid = false;
  Pose pose;
};

struct InitialPoint {
  bool valid = false;
  Eigen::Vector3d p_T = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_T =
      Eigen::Matrix3d::Zero();  ///< gauge: centroid, extent and first attitude exact
  int inliers = 0;              ///< observations that agree
};

/// T: axes of the first posed frame's camera, origin near the points' centroid, unit their RMS
/// distance from it.
struct InitialOutcome {
  InitialDecision decision = InitialDecision::kTooFewTracks;
  HypothesisKind winner = HypothesisKind::kFivePoint;
  bool winner_reversed = false;  ///< the winner is the depth-reversed solution of its seed
  double chi2_margin = 0.0;      ///< cost margin to the best rival of different geometry, noise
                                 ///< re-scaled where chi2 exceeds 1
  double reduced_chi2 = 0.0;     ///< robust
  double rotation_rad = 0.0;     ///< largest rotation from the first posed frame
  double depth_sigma =
      0.0;  ///< median 1-sigma of the points along the first line of sight, in extents
  double selection_depth_sigma = 0.0;  ///< the same, of the cores' tracks alone
  double convexity =
      0.0;  ///< curvature of the visible face over its 1-sigma; positive: the middle is nearest
  double inlier_ratio = 0.0;  ///< of the selection's observations beyond two of each track
  int hypotheses = 0;         ///< different ones that were refined to the end
  bool crowded = false;  ///< more frames than the selection has tracks for; fewer would decide more
  FixedVector<InitialFramePose, limits::kInitialFrames> frames;  ///< by frame
  FixedVector<InitialPoint, limits::kInitialTracks> points;      ///< by track
};

/// The frames and tracks on which hypotheses are compared.
struct SelectionSet {
  static constexpr std::size_t kInitialObservations =
      kSelectionObservations + kExtensionTracks * limits::kInitialFrames;
  FixedVector<InitialCore, 2>
      cores;  ///< a long run of frames; and one with many tracks, if that is another
  FixedVector<int, limits::kSelectionTracks> tracks;  ///< indices into InitialProblem::tracks
  FixedVector<TrackObservation, kInitialObservations> observations;
  std::size_t extension_observations = 0;  ///< the first of them, of the extension's tracks
};

/// Workspace of a selection, kept by the caller: some 5 MB. Holds nothing between calls.
struct InitialWorkspace {
  InitialAdjustmentWorkspace adjustment;
  SelectionSet set;
  InitialHypotheses seeds;
  InitialHypotheses refined;
  InitialHypothesis at_rest;
  FixedVector<InitialHypothesis, kFinalists> finalists;
  FixedVector<TrackObservation, kCoreTracks * kCoreFrames> core_observations;
  FixedVector<TrackObservation, InitialAdjustmentWorkspace::kInitialObservations> observations;
  std::array<InverseDepthPose, limits::kInitialFrames> poses;
  std::array<std::uint8_t, limits::kInitialFrames> posed;
  std::array<Eigen::Vector3d, limits::kInitialTracks> points_T;
  std::array<std::uint8_t, limits::kInitialTracks> known;
  std::array<Eigen::Matrix3d, limits::kInitialTracks> covariances;
};

}  // namespace polhode
