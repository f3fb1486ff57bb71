// Seeds of each kind from one core of exact tracks, against the geometry that made the tracks.
#include "initialisation/hypotheses.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "base/median.hpp"
#include "geometry/so3.hpp"
#include "solve/initial_adjustment.hpp"
#include "solve/initial_geometry.hpp"

namespace polhode::hypotheses_test {
namespace {

using testing::InitialGeometry;
using testing::InitialGeometryOptions;
using testing::make_initial_geometry;

/// A core of all frames and tracks.
struct Seeding {
  InitialGeometry g;
  InitialCore core;
  std::unique_ptr<InitialHypotheses> seeds = std::make_unique<InitialHypotheses>();

  Seeding(const InitialGeometryOptions& options, std::uint64_t seed)
      : g(make_initial_geometry(options, seed)) {
    for (int f = 0; f < options.frames; ++f) EXPECT_TRUE(core.frames.push_back(f));
    for (int i = 0; i < options.points; ++i) EXPECT_TRUE(core.tracks.push_back(i));
  }

  const InitialHypotheses& seed(std::uint32_t kinds, std::uint64_t draw = 1) {
    const SeedProblem problem{.times_s = g.times_s,
                              .observations = g.observations,
                              .selection_tracks = g.points_T.size(),
                              .core = &core,
                              .seed = draw,
                              .kinds = kinds};
    seed_hypotheses(problem, seeds.get());
    return *seeds;
  }

  /// The truth in the gauge of the seeds.
  InitialHypothesis truth() {
    InitialHypothesis h;
    h.frames = g.poses.size();
    h.tracks = g.points_T.size();
    std::copy(g.poses.begin(), g.poses.end(), h.poses.begin());
    std::copy(g.points_T.begin(), g.points_T.end(), h.points_T.begin());
    std::fill_n(h.posed.begin(), h.frames, std::uint8_t{1});
    std::fill_n(h.known.begin(), h.tracks, std::uint8_t{1});
    EXPECT_TRUE(normalise_gauge(h.view()));
    return h;
  }

  /// Distance of a seed's images from the tracks that one in ten exceeds.
  [[nodiscard]] double image_error(const InitialHypothesis& seed) const {
    std::vector<double> errors;
    for (const TrackObservation& s : g.observations) {
      Eigen::Vector2d x;
      const auto track = static_cast<std::size_t>(s.track);
      if (seed.known[track] != 0 &&
          reproject(seed.poses[static_cast<std::size_t>(s.frame)], seed.points_T[track], &x)) {
        errors.push_back((x - s.normalised).norm());
      }
    }
    return errors.empty() ? 1e300 : ranked(std::span(errors), errors.size() * 9 / 10);
  }

  /// Is the truth among the seeds, or its depth reversal where that is allowed? It explains the
  /// images to `image_tolerance`.
  bool holds_truth(double tolerance, double image_tolerance, bool reversed_too) {
    const InitialHypothesis true_one = truth();
    InitialHypothesis reversed = true_one;
    apply_depth_reversal(reversed.view());
    EXPECT_TRUE(normalise_gauge(reversed.view()));
    for (InitialHypothesis seed : *seeds) {
      if (!normalise_gauge(seed.view()) || image_error(seed) > image_tolerance) continue;
      if (same_geometry(seed, true_one, tolerance) ||
          (reversed_too && same_geometry(seed, reversed, tolerance))) {
        return true;
      }
    }
    return false;
  }
};

/// A body so near that perspective shows, and one so far that it does not.
constexpr InitialGeometryOptions kNear{.extent_over_range = 0.2};
constexpr InitialGeometryOptions kFar{.turn_rad = 0.8, .extent_over_range = 0.01};

// Image errors that are allowed. Two-view solvers are exact on exact tracks. Weak perspective
// leaves out a body's own depth: chosen, a twentieth of the 0.01 that the distant body subtends.
constexpr double kExact = 1e-6;
constexpr double kWeakPerspective = 5e-4;

TEST(SeedHypotheses, OfTwoViewsFindTheGeometry_WherePerspectiveShows) {
  for (std::uint64_t draw = 1; draw <= 5; ++draw) {
    Seeding s(kNear, draw);
    const InitialHypotheses& seeds = s.seed(kind_bit(HypothesisKind::kFivePoint), draw);
    ASSERT_FALSE(seeds.empty()) << draw;
    for (const InitialHypothesis& seed : seeds) EXPECT_EQ(seed.kind, HypothesisKind::kFivePoint);
    EXPECT_TRUE(s.holds_truth(0.05, kExact, false)) << draw;
  }
}

TEST(SeedHypotheses, OfFactorisationFindTheGeometryOfADistantBody_UpToItsDepthsSign) {
  for (std::uint64_t draw = 1; draw <= 5; ++draw) {
    Seeding s(kFar, draw);
    const InitialHypotheses& seeds = s.seed(kind_bit(HypothesisKind::kFactorisation), draw);
    ASSERT_FALSE(seeds.empty()) << draw;
    EXPECT_LE(seeds.size(), 3U);  // one a regularisation
    EXPECT_TRUE(s.holds_truth(0.15, kWeakPerspective, true)) << draw;
  }
}

TEST(SeedHypotheses, OfAConstantRateFindTheGeometry_UpToItsDepthsSign) {
  for (std::uint64_t draw = 1; draw <= 5; ++draw) {
    Seeding s(kFar, draw);
    ASSERT_FALSE(s.seed(kind_bit(HypothesisKind::kConstantRate), draw).empty()) << draw;
    EXPECT_TRUE(s.holds_truth(0.15, kWeakPerspective, true)) << draw;
  }
}

TEST(SeedHypotheses, OfAHomographyFindAPanel) {
  for (std::uint64_t draw = 1; draw <= 5; ++draw) {
    Seeding s({.extent_over_range = 0.2, .flat = true}, draw);
    const InitialHypotheses& seeds = s.seed(kind_bit(HypothesisKind::kHomography), draw);
    ASSERT_FALSE(seeds.empty()) << draw;
    for (const InitialHypothesis& seed : seeds) EXPECT_EQ(seed.kind, HypothesisKind::kHomography);
    EXPECT_TRUE(s.holds_truth(0.05, kExact, false)) << draw;
  }
}

TEST(SeedHypotheses, PoseAllFramesOfTheCoreAndNoOther) {
  Seeding s({.frames = 8, .extent_over_range = 0.2}, 3);
  s.core.frames.clear();
  for (const int f : {1, 2, 4, 5}) ASSERT_TRUE(s.core.frames.push_back(f));
  const InitialHypotheses& seeds = s.seed(kAllKinds);
  ASSERT_FALSE(seeds.empty());
  for (const InitialHypothesis& seed : seeds) {
    EXPECT_EQ(seed.frames, 8U);
    for (std::size_t f = 0; f < 8; ++f) {
      EXPECT_EQ(seed.posed[f] != 0, f == 1 || f == 2 || f == 4 || f == 5) << f;
    }
  }
}

TEST(SeedHypotheses, AreOfTheKindsAskedForAlone_AndReplaceWhatWasThere) {
  Seeding s(kNear, 2);
  const std::size_t of_all = s.seed(kAllKinds).size();
  std::size_t of_each = 0;
  for (const auto kind : {HypothesisKind::kFivePoint,
                          HypothesisKind::kHomography,
                          HypothesisKind::kFactorisation,
                          HypothesisKind::kConstantRate}) {
    for (const InitialHypothesis& seed : s.seed(kind_bit(kind))) EXPECT_EQ(seed.kind, kind);
    of_each += s.seeds->size();
  }
  EXPECT_EQ(of_all, of_each);
  EXPECT_TRUE(s.seed(0).empty());
}

TEST(SeedHypotheses, AreNoneOfTracksWithoutExtent) {
  Seeding s(kNear, 1);
  for (TrackObservation& observation : s.g.observations) observation.normalised.setZero();
  EXPECT_TRUE(s.seed(kAllKinds).empty());
}

TEST(SameGeometry, NeedsEightPointsInCommon) {
  Seeding s(kNear, 1);
  const InitialHypothesis a = s.truth();
  EXPECT_TRUE(same_geometry(a, a, 0.0));
  InitialHypothesis b = a;
  std::fill_n(b.known.begin(), b.tracks, std::uint8_t{0});
  std::fill_n(b.known.begin(), 8, std::uint8_t{1});
  EXPECT_TRUE(same_geometry(a, b, 0.1));
  b.known[0] = 0;
  EXPECT_FALSE(same_geometry(a, b, 0.1));
}

TEST(SameGeometry, ComparesRotationsFromTheFirstFrameThatBothPose) {
  Seeding s(kNear, 1);
  const InitialHypothesis a = s.truth();
  InitialHypothesis turned = a;
  for (std::size_t f = 0; f < a.frames; ++f) {
    turned.poses[f].R_CT = a.poses[f].R_CT * so3_exp({0.0, 0.0, 0.3});
  }
  InitialHypothesis reference = a;
  for (InitialHypothesis* h : {&turned, &reference}) h->posed[0] = 0;
  turned.poses[0] = {};
  // Other axes of the body leave the rotations between frames as they were.
  EXPECT_TRUE(same_geometry(reference, turned, 1e-9));
  turned.poses[3].R_CT = so3_exp({0.1, 0.0, 0.0}) * turned.poses[3].R_CT;
  EXPECT_FALSE(same_geometry(reference, turned, 0.1));
  turned.posed[3] = 0;
  EXPECT_TRUE(same_geometry(reference, turned, 1e-9));
}

}  // namespace
}  // namespace polhode::hypotheses_test
