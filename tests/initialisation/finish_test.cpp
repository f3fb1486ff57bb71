// The true geometry as the winner of the selection: what becomes of all tracks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "initialisation/core.hpp"
#include "initialisation/selection.hpp"
#include "solve/initial_adjustment.hpp"
#include "synthetic/initial_problem.hpp"

namespace polhode::finish_test {
namespace {

constexpr double kFocal_px = 2667.0;
constexpr double kNoise_px = 0.5;
constexpr double kUnknown = 1e300;  // depth sigma of an outcome that has none

InitialWorkspace& workspace() {
  static const auto w = std::make_unique<InitialWorkspace>();
  return *w;
}

struct Start {
  synthetic::Motion motion;
  std::vector<synthetic::Track> truth;
  std::vector<InitialTrack> tracks;
  InitialOptions options;

  explicit Start(std::uint64_t seed,
                 int points = 260,
                 int frames = 8,
                 double noise_px = kNoise_px) {
    Rng rng(seed, 9);
    const synthetic::Body body = synthetic::box(points, {0.3, 0.4, 0.5}, &rng);
    synthetic::ConstantTurn turn{.frames = frames, .turn_rad = 0.6};
    turn.axis_C = synthetic::direction_near_image_plane(0.5, &rng);
    turn.R_first = synthetic::random_attitude(&rng);
    turn.p_first_m = {0.05, 0.1, 5.0};
    turn.p_last_m = {0.0, 0.0, 4.9};
    motion = synthetic::constant_turn(turn, &rng);
    truth = synthetic::track_points(
        body, motion, {.noise_px = noise_px, .all_frames_only = true}, &rng);
    tracks = synthetic::to_start_tracks(truth, kNoise_px / kFocal_px);
  }

  [[nodiscard]] InitialProblem problem() const {
    return {.times_s = motion.times_s, .tracks = tracks};
  }

  /// Wrong matches in frames [first, last), 30 px to one side and to the other.
  void displace(std::size_t track, std::size_t first, std::size_t last) {
    for (std::size_t f = first; f < last; ++f) {
      tracks[track].observations[f].normalised.x() += (f % 2 == 0 ? 30.0 : -30.0) / kFocal_px;
    }
  }

  /// The truth in the gauge of a start, on the tracks of the selection.
  void win() const {
    InitialWorkspace& w = workspace();
    ASSERT_TRUE(choose_selection_set(problem(), &w.set));
    InitialHypothesis h;
    h.frames = motion.poses.size();
    h.tracks = w.set.tracks.size();
    for (std::size_t f = 0; f < h.frames; ++f) {
      h.poses[f] = to_inverse_depth(motion.poses[f]);
      h.posed[f] = 1;
    }
    for (std::size_t k = 0; k < h.tracks; ++k) {
      h.points_T[k] = truth[static_cast<std::size_t>(w.set.tracks[k])].p_B;
      h.known[k] = 1;
    }
    ASSERT_TRUE(normalise_gauge(h.view()));
    w.refined.clear();
    ASSERT_TRUE(w.refined.push_back(h));
  }

  [[nodiscard]] InitialOutcome finish() const {
    const InitialProblem of_all = problem();
    InitialOutcome out;
    adjust_all_tracks({.problem = of_all, .options = options}, &workspace(), &out);
    return out;
  }
};

TEST(AdjustAllTracks, GivesEveryTrackItsPointAndEveryFrameItsPose) {
  Start start(1);
  start.win();
  const InitialOutcome out = start.finish();
  ASSERT_EQ(out.points.size(), start.tracks.size());
  ASSERT_EQ(out.frames.size(), 8U);
  ASSERT_GT(start.tracks.size(), 60U);
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    EXPECT_TRUE(out.points[i].valid) << i;
    EXPECT_GE(out.points[i].inliers, 7) << i;  // 3e-4 of good images lie beyond 4 sigma
  }
  const synthetic::InitialErrors errors = synthetic::compare_start(out, start.truth, start.motion);
  EXPECT_LT(errors.depth, 0.1);
  EXPECT_LT(errors.rotation, 0.1);
  EXPECT_NEAR(out.rotation_rad, 0.6, 0.06);
  EXPECT_TRUE(out.frames[0].pose.R_CT.isIdentity(1e-9));
  EXPECT_GT(out.depth_sigma, 0.0);
  EXPECT_LT(out.depth_sigma, 0.06);
  EXPECT_LT(out.selection_depth_sigma, 0.06);
}

TEST(AdjustAllTracks, IsExactWithoutNoise) {
  Start start(2, 260, 8, 0.0);
  start.win();
  const synthetic::InitialErrors errors =
      synthetic::compare_start(start.finish(), start.truth, start.motion);
  EXPECT_LT(errors.depth, 1e-4);
  EXPECT_LT(errors.rotation, 1e-4);
}

TEST(AdjustAllTracks, DropsATrackThatIsWrongInAllFrames) {
  Start start(3);
  start.win();
  const std::size_t wrong = start.tracks.size() - 1;
  start.displace(wrong, 0, 8);
  const InitialOutcome out = start.finish();
  EXPECT_FALSE(out.points[wrong].valid);
  EXPECT_EQ(out.points[wrong].inliers, 0);
  EXPECT_TRUE(out.points[0].valid);
}

TEST(AdjustAllTracks, KeepsATrackOfWhichHalfAgreesWithItsPoint) {
  // The winner has the points of the selection, however wrong their images.
  Start start(3);
  start.win();
  const auto mostly_right = static_cast<std::size_t>(workspace().set.tracks[1]);
  const auto mostly_wrong = static_cast<std::size_t>(workspace().set.tracks[2]);
  start.displace(mostly_right, 0, 3);
  start.displace(mostly_wrong, 0, 5);
  const InitialOutcome out = start.finish();
  EXPECT_TRUE(out.points[mostly_right].valid);
  EXPECT_EQ(out.points[mostly_right].inliers, 5);
  EXPECT_FALSE(out.points[mostly_wrong].valid);
  EXPECT_EQ(out.points[mostly_wrong].inliers, 0);
}

TEST(AdjustAllTracks, MakesNoPointOfASingleImage) {
  Start start(4);
  start.win();
  InitialTrack& last = start.tracks.back();
  while (last.observations.size() > 1) last.observations.pop_back();
  const InitialOutcome out = start.finish();
  EXPECT_FALSE(out.points[start.tracks.size() - 1].valid);
  EXPECT_EQ(out.points[start.tracks.size() - 1].inliers, 0);
}

TEST(AdjustAllTracks, LeavesFramesWithoutAPose) {
  Start start(5);
  start.win();
  workspace().refined[0].posed[4] = 0;
  const InitialOutcome out = start.finish();
  EXPECT_FALSE(out.frames[4].valid);
  EXPECT_TRUE(out.frames[3].valid);
  EXPECT_EQ(out.points[0].inliers, 7);
}

TEST(AdjustAllTracks, KeepsToTheAdjustmentsCapacity) {
  // 32 frames: 375 tracks fill it.
  Start start(6, 2400, 32);
  constexpr std::size_t kFit = InitialAdjustmentWorkspace::kInitialObservations / 32;
  ASSERT_GT(start.tracks.size(), kFit + 50);
  start.win();
  const InitialOutcome out = start.finish();
  std::size_t valid = 0;
  for (const InitialPoint& point : out.points) valid += point.valid ? 1U : 0U;
  EXPECT_GT(valid, kFit - 20);
  // Tracks of the selection are known whether or not their images were taken in.
  EXPECT_LE(valid, kFit + workspace().set.tracks.size());
}

TEST(AdjustAllTracks, OfAWinnerWithoutPosesGivesNothing) {
  Start start(7);
  start.win();
  workspace().refined[0].posed.fill(0);
  workspace().refined[0].known.fill(0);
  const InitialOutcome out = start.finish();
  EXPECT_EQ(out.depth_sigma, kUnknown);
  EXPECT_EQ(out.selection_depth_sigma, kUnknown);
  ASSERT_EQ(out.points.size(), start.tracks.size());
  for (const InitialPoint& point : out.points) EXPECT_FALSE(point.valid);
  for (const InitialFramePose& frame : out.frames) EXPECT_FALSE(frame.valid);
}

}  // namespace
}  // namespace polhode::finish_test
