// Costs by hand: one camera ten units before the body, so that an image is off by sigmas that are
// chosen.
#include "solve/initial_residuals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace polhode::initial_residuals_test {
namespace {

constexpr double kSigma = 1e-3;
constexpr InitialAdjustmentOptions kTruncated{.loss = InitialLoss::kTruncated, .width_sigma = 4.0};
constexpr InitialAdjustmentOptions kCauchy{.loss = InitialLoss::kCauchy, .width_sigma = 4.0};

struct Geometry {
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> posed;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> known;
  std::vector<TrackObservation> observations;

  InitialGeometryView view() { return {poses, posed, points_T, known}; }
  /// One track more, seen in as many frames as there are sigmas, off by these in x.
  void add_track(const std::vector<double>& off_sigmas) {
    const int track = static_cast<int>(points_T.size());
    points_T.emplace_back(0.1 * track, -0.1, 0.0);
    known.push_back(1);
    for (std::size_t f = 0; f < off_sigmas.size(); ++f) {
      if (poses.size() <= f) {
        poses.push_back({.uvs = {0.0, 0.0, 0.1}});
        posed.push_back(1);
      }
      TrackObservation s{.frame = static_cast<int>(f), .track = track, .sigma_normalised = kSigma};
      Eigen::Vector2d seen;
      EXPECT_TRUE(reproject(poses[f], points_T.back(), &seen));
      s.normalised = seen;
      s.normalised.x() += off_sigmas[f] * kSigma;
      observations.push_back(s);
    }
  }
};

InitialFit evaluate(Geometry* g, const InitialAdjustmentOptions& options) {
  static const auto workspace = std::make_unique<InitialAdjustmentWorkspace>();
  return evaluate_initial(g->observations, g->view(), options, workspace.get());
}

double total(Geometry* g, const InitialAdjustmentOptions& options) {
  return total_cost(g->observations, g->poses, g->points_T, g->view(), options);
}

TEST(InitialWeight, EndsAtTheTruncationAndFallsWithCauchy) {
  EXPECT_EQ(initial_weight(15.9, kTruncated), 1.0);
  EXPECT_EQ(initial_weight(16.0, kTruncated), 0.0);
  EXPECT_EQ(initial_weight(16.0, kCauchy), 0.5);
  EXPECT_EQ(truncated_max(kTruncated), 16.0);
}

TEST(TrackEnd, IsWhereTheNextTrackBegins) {
  Geometry g;
  g.add_track({0.0, 0.0, 0.0});
  g.add_track({0.0});
  g.add_track({0.0, 0.0});
  EXPECT_EQ(track_end(g.observations, 0), 3U);
  EXPECT_EQ(track_end(g.observations, 1), 3U);
  EXPECT_EQ(track_end(g.observations, 3), 4U);
  EXPECT_EQ(track_end(g.observations, 4), 6U);
}

TEST(InitialCost, AddsSquaresWithinTheTruncation) {
  Geometry g;
  g.add_track({1.0, -2.0, 0.5});
  g.add_track({0.0, 1.0, 0.0});
  EXPECT_NEAR(total(&g, kTruncated), 1.0 + 4.0 + 0.25 + 1.0, 1e-6);
  EXPECT_NEAR(total(&g, kCauchy),
              16.0 * (2.0 * std::log1p(1.0 / 16.0) + std::log1p(0.25) + std::log1p(0.25 / 16.0)),
              1e-6);
}

TEST(InitialCost, OfAnObservationWithoutPoseOrPointIsThatOfALostOne) {
  Geometry g;
  g.add_track({0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  g.posed[2] = 0;
  EXPECT_NEAR(total(&g, kTruncated), 16.0, 1e-6);
  EXPECT_NEAR(total(&g, kCauchy), 0.0, 1e-6);
  g.posed[2] = 1;
  g.known[0] = 0;
  // Eight lost ones would cost 128: more than a track of 13 degrees of freedom may.
  EXPECT_NEAR(total(&g, kTruncated), 13.0 + 3.0 * std::sqrt(26.0), 1e-6);
}

TEST(InitialCost, OfAWrongTrackIsBoundedByItsLength) {
  Geometry g;
  g.add_track({3.9, 3.9, 3.9, 3.9, 3.9, 3.9});
  const double most = 9.0 + 3.0 * std::sqrt(18.0);  // 2 * 6 - 3 degrees of freedom
  const TrackCost cost = track_cost(g.observations, g.view(), kTruncated);
  EXPECT_TRUE(cost.wrong);
  EXPECT_NEAR(cost.cost, most, 1e-6);
  EXPECT_FALSE(track_cost(g.observations, g.view(), kCauchy).wrong);
  Geometry right;
  right.add_track({1.0, 1.0, 1.0, 1.0, 1.0, 1.0});
  EXPECT_FALSE(track_cost(right.observations, right.view(), kTruncated).wrong);
}

TEST(InitialCost, CountsAPointBehindTheCameraAsFarOff) {
  Geometry g;
  g.add_track({0.0});
  g.points_T[0] = {0.0, 0.0, -20.0};
  EXPECT_NEAR(total(&g, kCauchy), 16.0 * std::log1p(behind_error2(kCauchy) / 16.0), 1e-6);
}

TEST(InitialCost, IsCountedInScaledSigmas) {
  Geometry g;
  g.add_track({2.0, 2.0});
  InitialAdjustmentOptions twice = kTruncated;
  twice.sigma_scale = 2.0;
  EXPECT_NEAR(total(&g, twice), 2.0, 1e-6);
}

TEST(InitialCost, TakesOtherPosesAndPointsInPlaceOfTheGeometrysOwn) {
  Geometry g;
  g.add_track({0.0, 0.0});
  std::vector<Eigen::Vector3d> elsewhere = g.points_T;
  elsewhere[0].x() += 0.01;  // a tenth of a range of ten: 1 sigma
  EXPECT_NEAR(total_cost(g.observations, g.poses, elsewhere, g.view(), kTruncated), 2.0, 1e-6);
  EXPECT_NEAR(total(&g, kTruncated), 0.0, 1e-6);
}

TEST(EvaluateInitial, CountsInliersPointsFramesAndLeavesWrongTracksOut) {
  Geometry g;
  g.add_track({1.0, 1.0, 1.0, 1.0, 1.0, 1.0});
  g.add_track({1.0, 1.0, 9.0, 1.0, 1.0, 1.0});  // one wrong match, a right track
  g.add_track({9.0, 9.0, 9.0, 9.0, 9.0, 1.0});  // a wrong track
  g.add_track({1.0, 1.0, 1.0, 1.0, 1.0, 1.0});
  g.known[3] = 0;
  g.poses.push_back({});  // a frame without a pose
  g.posed.push_back(0);
  const InitialFit fit = evaluate(&g, kTruncated);
  EXPECT_EQ(fit.observations, 24);
  EXPECT_EQ(fit.frames, 6);
  EXPECT_EQ(fit.inliers, 6 + 5);
  EXPECT_EQ(fit.points, 2);
  EXPECT_NEAR(fit.chi2, 11.0, 1e-6);
  EXPECT_NEAR(fit.median, 1.0, 1e-6);
  EXPECT_NEAR(fit.cost, total(&g, kTruncated), 1e-12);
}

TEST(EvaluateInitial, CountsWhatTellsBeyondTwoImagesOfATrack_AndWhatOfItAgrees) {
  Geometry g;
  g.add_track({1.0, 1.0, 1.0, 1.0, 1.0, 1.0});  // 4 redundant, 4 agree
  g.add_track({1.0, 1.0, 9.0, 1.0, 1.0});       // 3 redundant, 2 agree
  g.add_track({9.0, 9.0, 9.0, 9.0, 1.0});       // 3 redundant, none agrees
  g.add_track({0.0, 0.0});                      // a point agrees with any two images
  const InitialFit fit = evaluate(&g, kTruncated);
  EXPECT_EQ(fit.redundant, 4 + 3 + 3);
  EXPECT_EQ(fit.agreeing, 4 + 2);
  g.known[0] = 0;
  EXPECT_EQ(evaluate(&g, kTruncated).redundant, 10) << "a lost one tells too";
  EXPECT_EQ(evaluate(&g, kTruncated).agreeing, 2);
}

TEST(EvaluateInitial, ATrackOfOneImageGivesNothing) {
  Geometry g;
  g.add_track({1.0, 1.0, 1.0, 1.0});
  g.add_track({0.0});
  g.add_track({9.0});
  const InitialFit fit = evaluate(&g, kTruncated);
  EXPECT_EQ(fit.redundant, 2);
  EXPECT_EQ(fit.agreeing, 2);
}

TEST(EvaluateInitial, ScalesTheNoiseByWhatTheFitHasTakenUp) {
  Geometry g;
  for (int i = 0; i < 20; ++i) g.add_track({1.0, 1.0, 1.0, 1.0, 1.0, 1.0});
  const InitialFit fit = evaluate(&g, kTruncated);
  // 240 coordinates, 20 points, 6 frames and 7 freedoms of the gauge: 151 are free.
  EXPECT_NEAR(fit.noise_scale, std::sqrt(1.0 / 1.3863 * 240.0 / 151.0), 1e-4);
  Geometry few;
  few.add_track({1.0, 1.0});
  few.add_track({1.0, 1.0});
  EXPECT_EQ(evaluate(&few, kTruncated).noise_scale, 0.0);  // 8 - 6 - 12 + 7: none is free
}

TEST(EvaluateInitial, OfNothingIsNothing) {
  Geometry g;
  const InitialFit fit = evaluate(&g, kTruncated);
  EXPECT_EQ(fit.cost, 0.0);
  EXPECT_EQ(fit.inliers, 0);
  EXPECT_EQ(fit.median, 0.0);
}

TEST(TrackCosts, AreGivenByTrackAndZeroWithoutObservations) {
  Geometry g;
  g.add_track({1.0, 1.0});
  g.add_track({});
  g.add_track({2.0, 0.0});
  std::vector<double> costs(3, -1.0);
  initial_track_costs(g.observations, g.view(), kTruncated, costs);
  EXPECT_NEAR(costs[0], 2.0, 1e-6);
  EXPECT_EQ(costs[1], 0.0);
  EXPECT_NEAR(costs[2], 4.0, 1e-6);
}

}  // namespace
}  // namespace polhode::initial_residuals_test
