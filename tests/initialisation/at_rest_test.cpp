#include "initialisation/at_rest.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "initialisation/initialise.hpp"
#include "synthetic/initial_scenarios.hpp"

namespace polhode::at_rest_test {
namespace {

using synthetic::InitialScenario;

struct Passage {
  int frames = 8;
  int points = 120;
  double turn_deg = 0.0;      ///< of the body over all frames, about an axis across the view
  double bearing_deg = 7.0;   ///< that the body moves across
  double range_ratio = 0.92;  ///< of the last range to the first
  double range_m = 12.0;
  double noise_px = 0.3;
};

/// A box of about a metre that passes a camera.
InitialScenario passing_box(const Passage& passage, std::uint64_t seed) {
  const double kRange_m = passage.range_m;
  Rng rng(seed, 5);
  InitialScenario s;
  const synthetic::Body body = synthetic::box(passage.points, {0.3, 0.4, 0.5}, &rng);
  synthetic::ConstantTurn turn{.frames = passage.frames,
                               .turn_rad = passage.turn_deg * synthetic::detail::kDegree,
                               .axis_C = synthetic::direction_near_image_plane(0.3, &rng),
                               .R_first = so3_exp(2.0 * synthetic::random_direction(&rng))};
  const double across_m = kRange_m * passage.bearing_deg * synthetic::detail::kDegree;
  turn.p_first_m = {-0.5 * across_m, 0.01 * kRange_m, kRange_m};
  turn.p_last_m = {0.5 * across_m, 0.0, passage.range_ratio * kRange_m};
  s.motion = synthetic::constant_turn(turn, &rng);
  s.tracks = synthetic::track_points(
      body, s.motion, {.noise_px = passage.noise_px, .all_frames_only = true}, &rng);
  s.sigma_normalised = passage.noise_px / synthetic::detail::kFocal_px;
  return s;
}

InitialOutcome run(const InitialScenario& s, std::uint64_t seed) {
  static const auto workspace = std::make_unique<InitialWorkspace>();
  const std::vector<InitialTrack> tracks = synthetic::to_start_tracks(s.tracks, s.sigma_normalised);
  return select_hypothesis({.times_s = s.motion.times_s, .tracks = tracks, .seed = seed},
                           InitialOptions{},
                           workspace.get());
}

/// Starts that hold a body still, of those that find a geometry at all.
int at_rest(const Passage& passage) {
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const InitialOutcome out = run(passing_box(passage, seed), seed);
    count += out.decision == InitialDecision::kCommit && out.rotation_rad < 1e-9 ? 1 : 0;
  }
  return count;
}

TEST(AtRest, ABodyThatPassesIsHeldStill) {
  EXPECT_GE(at_rest({}), 15);
  EXPECT_GE(at_rest({.bearing_deg = 10.0}), 15);
}

TEST(AtRest, ABodyThatRotatesSteadilyIsNot) {
  for (const double turn_deg : {5.0, 8.0, 20.0}) {
    EXPECT_EQ(at_rest({.turn_deg = turn_deg}), 0) << turn_deg;
  }
}

TEST(AtRest, NorIsOneSeenByFewNoisyPoints) {
  // Each frame's free rotation has three unknowns, and so few observations do not pay for them. Of
  // 20 starts four were held still until a steady rotation, of three in all, was a rival.
  for (const double bearing_deg : {8.0, 15.0}) {
    EXPECT_EQ(at_rest({.frames = 7,
                       .points = 100,
                       .turn_deg = 5.0,
                       .bearing_deg = bearing_deg,
                       .range_ratio = 0.7,
                       .range_m = 6.0,
                       .noise_px = 1.0}),
              0)
        << bearing_deg;
  }
}

}  // namespace
}  // namespace polhode::at_rest_test
