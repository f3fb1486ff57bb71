#include "decidability.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "initialisation/initialise.hpp"
#include "synthetic/initial_scenarios.hpp"

namespace polhode::decidability_test {
namespace {

using benchmark::Decidability;
using synthetic::compare_start;
using synthetic::InitialFamily;
using synthetic::InitialScenario;
using synthetic::make_initial_scenario;
using synthetic::to_start_tracks;

InitialWorkspace& workspace() {
  static const auto w = std::make_unique<InitialWorkspace>();
  return *w;
}

struct View {
  double alpha_deg = 10.0;
  double turn_deg = 40.0;
  double noise_px = 0.5;
  double outlier_tracks = 0.0;
};

/// A box that turns by its corner before the camera; sigmas are as large as the noise.
InitialScenario turning_box(const View& view, std::uint64_t seed) {
  Rng rng(seed, 7);
  InitialScenario s;
  const synthetic::Body body = synthetic::box(260, {0.3, 0.4, 0.5}, &rng);
  const double range = 0.7 / (view.alpha_deg * synthetic::detail::kDegree);
  synthetic::ConstantTurn turn{.frames = 8, .turn_rad = view.turn_deg * synthetic::detail::kDegree};
  turn.axis_C = synthetic::direction_near_image_plane(0.5, &rng);
  turn.R_first = synthetic::detail::facing(0.9, &rng);
  turn.p_first_m = {0.01 * range, 0.02 * range, range};
  turn.p_last_m = {0.0, 0.0, 0.98 * range};
  s.motion = synthetic::constant_turn(turn, &rng);
  s.tracks = synthetic::track_points(
      body,
      s.motion,
      {.noise_px = view.noise_px, .outlier_tracks = view.outlier_tracks, .all_frames_only = true},
      &rng);
  s.sigma_normalised = view.noise_px / synthetic::detail::kFocal_px;
  return s;
}

Decidability decide(const InitialScenario& s) {
  const std::vector<InitialTrack> tracks = to_start_tracks(s.tracks, s.sigma_normalised);
  return benchmark::decide_by_truth(
      {.times_s = s.motion.times_s, .tracks = tracks, .seed = 1}, s.motion.poses, &workspace());
}

TEST(Decidability, GrowsWithPerspectiveAndTurn) {
  const double near = decide(turning_box({}, 1)).margin;
  const double far = decide(turning_box({.alpha_deg = 2.0}, 1)).margin;
  const double still = decide(turning_box({.turn_deg = 4.0}, 1)).margin;
  EXPECT_GT(near, 200.0);
  EXPECT_LT(far, 0.2 * near);
  EXPECT_LT(still, 0.2 * near);
}

TEST(Decidability, FallsWithTheSquareOfTheNoise) {
  // Far enough that no residual reaches the truncation.
  const double fine =
      decide(turning_box({.alpha_deg = 3.0, .turn_deg = 20.0, .noise_px = 0.5}, 2)).margin;
  const double coarse =
      decide(turning_box({.alpha_deg = 3.0, .turn_deg = 20.0, .noise_px = 1.0}, 2)).margin;
  EXPECT_NEAR(coarse / fine, 0.25, 0.08);
}

TEST(Decidability, IsOverTheNoiseThatTheImagesHave_NotThatTheyClaim) {
  InitialScenario s = turning_box({}, 3);
  const Decidability honest = decide(s);
  s.sigma_normalised /= 1.6;
  const Decidability boasting = decide(s);
  EXPECT_NEAR(honest.noise, 1.0, 0.15);
  EXPECT_NEAR(boasting.noise, 1.6, 0.25);
  EXPECT_NEAR(boasting.margin / honest.margin, 1.0, 0.3);
}

TEST(Decidability, LeavesWrongTracksOut) {
  const Decidability found = decide(turning_box({.outlier_tracks = 0.25}, 4));
  ASSERT_TRUE(found.known);
  EXPECT_NEAR(found.agreeing, 0.75, 0.12);
}

TEST(Decidability, IsUnknown_WithoutTracks) {
  const std::vector<InitialTrack> none;
  const InitialScenario s = turning_box({}, 5);
  EXPECT_FALSE(benchmark::decide_by_truth(
                   {.times_s = s.motion.times_s, .tracks = none}, s.motion.poses, &workspace())
                   .known);
}

TEST(Decidability, TellsWhereASelectionCommits) {
  int decided = 0;
  int open = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const double alpha_deg : {1.0, 10.0}) {
      const InitialScenario s = turning_box({.alpha_deg = alpha_deg, .turn_deg = 25.0}, seed);
      const double margin = decide(s).margin;
      const std::vector<InitialTrack> tracks = to_start_tracks(s.tracks, s.sigma_normalised);
      const InitialOutcome out = select_hypothesis(
          {.times_s = s.motion.times_s, .tracks = tracks, .seed = seed}, {}, &workspace());
      // The margin scatters by twice its root.
      if (margin > 100.0) {
        EXPECT_EQ(out.decision, InitialDecision::kCommit) << seed << ": " << margin;
        EXPECT_TRUE(compare_start(out, s.tracks, s.motion).right()) << seed;
        ++decided;
      } else if (margin < 4.0) {
        EXPECT_NE(out.decision, InitialDecision::kCommit) << seed << ": " << margin;
        ++open;
      }
    }
  }
  EXPECT_GE(decided, 4);
  EXPECT_GE(open, 4);
}

}  // namespace
}  // namespace polhode::decidability_test
