// A view that shows too little for a pose of its own, held by what is expected of it.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "seen_frame.hpp"

namespace polhode::find_with_prior_test {
namespace {

using namespace synthetic;

// 1-sigmas of the prediction.
constexpr double kTurnSigma_rad = 0.01;
constexpr double kShiftSigma_mu = 0.02;

/// A mapped body, and an image in which few of its spots are left.
struct Bench : SeenFrame {
  std::vector<Spot> body = ball(400, 11);
  Pose truth = turned(0.3);

  /// @param left  mapped spots that are seen.
  /// @param every  of the mapped spots: seven spreads few over the side.
  explicit Bench(int left, std::uint64_t seed = 1, int clutter = 0, std::size_t every = 7) {
    const SyntheticMap mapped = make_map(body, turn_by(0.12, 6), kNoise_px, 11);
    state->map = *mapped.map;
    Rng rng(seed, 131);
    const Picture all = take_image(body, truth, kNoise_px, 0, &rng);
    for (std::size_t i = 0; i < all.spot_of.size() && left > 0; i += every) {
      if (mapped.landmark_of[static_cast<std::size_t>(all.spot_of[i])].valid()) {
        EXPECT_TRUE(image.features->push_back((*all.features)[i]));
        --left;
      }
    }
    EXPECT_EQ(left, 0);
    const Picture nothing = take_image({}, truth, kNoise_px, clutter, &rng);
    for (const Feature& feature : *nothing.features) {
      EXPECT_TRUE(image.features->push_back(feature));
    }
  }

  /// A tried motion's prediction that is off by so much about the vertical and to the side.
  [[nodiscard]] ExpectedPose expected(double off_rad, double off_mu = 0.0) const {
    ExpectedPose e;
    e.prediction.pose = {.R_CT = so3_exp(off_rad * Eigen::Vector3d::UnitY()) * truth.R_CT,
                         .p_CT = truth.p_CT + Eigen::Vector3d(off_mu, 0.0, 0.0)};
    Eigen::Matrix<double, 6, 1> sigmas;
    sigmas << Eigen::Vector3d::Constant(kTurnSigma_rad), Eigen::Vector3d::Constant(kShiftSigma_mu);
    e.prediction.covariance = sigmas.cwiseAbs2().asDiagonal();
    e.prediction.rotation_poses = 20;
    e.prediction.position_poses = 20;
    e.poses_since_start = 20;
    e.step_rad = 0.05;
    return e;
  }

  bool hold(const ExpectedPose& e) { return find_with_prior(input(), e, state.get()); }

  [[nodiscard]] double error_rad() const {
    return rotation_angle_rad(state->localised.absolute.pose.R_CT, truth.R_CT);
  }
  [[nodiscard]] double normalised_error2() const {
    const AbsolutePose& found = state->localised.absolute;
    Eigen::Matrix<double, 6, 1> e;
    e << so3_log(truth.R_CT * found.pose.R_CT.transpose()), truth.p_CT - found.pose.p_CT;
    return e.dot(found.covariance.ldlt().solve(e));
  }
};

TEST(FindWithPrior, FindsAViewOfEightLandmarks_ThatIsTooLittleForAPoseOfItsOwn) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Bench b(8, seed);
    const ExpectedPose e = b.expected(0.01, -0.02);
    EXPECT_FALSE(find_about(b.input(), e, b.state.get())) << seed;
    EXPECT_FALSE(relocalise_frame(b.input(), b.state.get())) << seed;
    ASSERT_TRUE(b.hold(e)) << seed;
    EXPECT_GE(b.state->localised.absolute.inliers, 7) << seed;
    squares += b.error_rad() * b.error_rad();
    EXPECT_LT(b.normalised_error2(), 27.9) << "99.99 % of six numbers: seed " << seed;
  }
  EXPECT_LT(std::sqrt(squares / 10.0), 0.01) << "nearer than the prediction";
}

TEST(FindWithPrior, MarksTheMatchesThatAgree) {
  Bench b(9);
  for (Feature& feature : *b.image.features) {
    feature.u_px += &feature == &(*b.image.features)[4] ? 12.0F : 0.0F;
    feature.normalised =
        undistort(b.model, {static_cast<double>(feature.u_px), static_cast<double>(feature.v_px)});
  }
  ASSERT_TRUE(b.hold(b.expected(0.0)));
  int inliers = 0;
  for (const LandmarkMatch& match : b.state->localised.matches) {
    EXPECT_EQ(match.inlier, match.feature != 4) << match.feature;
    inliers += match.inlier ? 1 : 0;
  }
  EXPECT_EQ(inliers, b.state->localised.absolute.inliers);
}

TEST(FindWithPrior, IsNotMisledByClutter) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Bench b(10, seed, 200);
    ASSERT_TRUE(b.hold(b.expected(0.01, -0.02))) << seed;
    EXPECT_LT(b.normalised_error2(), 27.9) << seed;
  }
}

TEST(FindWithPrior, FindsNothing_WhereTooFewLandmarksAreLeft) {
  // Beyond six, one for every eight matches may be by chance.
  EXPECT_FALSE(Bench(5).hold(Bench(5).expected(0.0)));
  EXPECT_TRUE(Bench(7).hold(Bench(7).expected(0.0)));
}

TEST(FindWithPrior, FindsNothing_WhereTheFeaturesAreAnotherBodys) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Bench b(0, seed);
    Rng rng(seed, 132);
    b.image = take_image(ball(400, 12), b.truth, kNoise_px, 0, &rng);
    EXPECT_FALSE(b.hold(b.expected(0.0))) << seed;
  }
}

TEST(FindWithPrior, FindsNothingByAYoungMotion) {
  Bench b(8);
  ExpectedPose young = b.expected(0.0);
  ASSERT_TRUE(b.hold(young));
  young.poses_since_start = 5;
  EXPECT_FALSE(b.hold(young)) << "only the start's own poses have checked it";
  young = b.expected(0.0);
  young.prediction.rotation_poses = 5;
  EXPECT_FALSE(b.hold(young));
}

TEST(FindWithPrior, FindsNothingByAnUncertainMotion) {
  Bench b(8);
  ExpectedPose uncertain = b.expected(0.0);
  uncertain.prediction.covariance(1, 1) = 0.06 * 0.06;
  EXPECT_FALSE(b.hold(uncertain));
  uncertain = b.expected(0.0);
  uncertain.step_rad = 1.2;
  EXPECT_FALSE(b.hold(uncertain)) << "a twentieth of so long a step";
  uncertain = b.expected(0.0);
  uncertain.prediction.covariance(0, 0) = std::nan("");
  EXPECT_FALSE(b.hold(uncertain));
}

TEST(FindWithPrior, FindsNothing_WhereThePredictionIsOffByMoreThanItSays) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Bench b(8, seed);
    EXPECT_FALSE(b.hold(b.expected(0.0, 0.15))) << "28 px: seed " << seed;
    EXPECT_FALSE(b.hold(b.expected(0.15))) << "28 px in the middle: seed " << seed;
  }
}

// So many features that are nothing leave no pose the two thirds of its matches that need no
// motion.
constexpr int kClutter = 800;

/// Half of the features are of other spots, as glints are: a pose with half of its matches needs
/// the motion's word.
void displace_half(Bench* b) {
  Rng rng(3, 17);
  Features& features = *b->image.features;
  for (std::size_t i = 0; i < features.size(); i += 2) {
    const double direction_rad = 6.283 * rng.uniform();
    features[i].u_px += static_cast<float>(3.0 * std::cos(direction_rad));
    features[i].v_px += static_cast<float>(3.0 * std::sin(direction_rad));
    features[i].normalised = undistort(
        b->model, {static_cast<double>(features[i].u_px), static_cast<double>(features[i].v_px)});
  }
}

TEST(FindAboutInconsistent, IsConfirmedByHalfOfTheLastInliers) {
  for (const auto& [inliers_last, found] : {std::pair(30, true), std::pair(90, false)}) {
    Bench b(30, 1, 0, 3);
    b.state->before.inliers = inliers_last;
    const ExpectedPose e = b.expected(0.01);
    EXPECT_TRUE(find_about(b.input(), e, b.state.get())) << inliers_last;
    EXPECT_EQ(find_about_inconsistent(b.input(), e, b.state.get()), found) << inliers_last;
  }
}

// Off the motion by what a contact can do: twice a step.
constexpr double kTouched_rad = 0.12;

/// What tracking does where features give no pose that the motion confirms.
bool overruled(const ExpectedPose& e, Bench* b) {
  displace_half(b);
  EXPECT_FALSE(find_about(b->input(), e, b->state.get()));
  return overrule_motion(b->input(), e, b->hold(e), b->state.get());
}

TEST(OverruleMotion, TakesThePoseOfManyLandmarks_WhereTheBodyWasTouched) {
  Bench b(100, 1, 0, 1);
  b.state->before.inliers = 55;
  EXPECT_TRUE(overruled(b.expected(kTouched_rad), &b));
  EXPECT_LT(b.error_rad(), 0.01);
  EXPECT_GT(b.state->localised.absolute.inliers, 40);
}

TEST(OverruleMotion, KeepsTheMotion_WhereNoContactBringsTheBodyThere) {
  constexpr double kOff_rad = 0.55;
  for (const auto& [step_rad, reached] : {std::pair(0.3, true), std::pair(0.05, false)}) {
    Bench b(100, 1, 0, 1);
    b.state->before.inliers = 55;
    ExpectedPose e = b.expected(kOff_rad);
    e.step_rad = step_rad;
    EXPECT_EQ(overruled(e, &b), reached) << step_rad;
  }
}

TEST(OverruleMotion, KeepsTheMotion_WhereLessIsSeenThanBefore) {
  Bench b(100, 1, 0, 1);
  b.state->before.inliers = 150;
  EXPECT_FALSE(overruled(b.expected(kTouched_rad), &b));
}

TEST(OverruleMotion, KeepsTheMotion_WhereFewLandmarksContradictIt) {
  Bench b(50, 1, 0, 1);
  b.state->before.inliers = 25;
  EXPECT_FALSE(overruled(b.expected(kTouched_rad), &b));
}

TEST(OverruleMotion, KeepsTheMotion_WhereItHoldsNearlyAsMany) {
  Bench b(100, 1, 0, 1);
  b.state->before.inliers = 55;
  const ExpectedPose e = b.expected(kTouched_rad);
  displace_half(&b);
  EXPECT_FALSE(find_about(b.input(), e, b.state.get()));
  ASSERT_FALSE(b.state->scratch.other.matches.empty());
  b.state->localised.absolute.inliers = b.state->scratch.other.absolute.inliers - 5;
  EXPECT_FALSE(overrule_motion(b.input(), e, true, b.state.get()));
}

/// A pose that nearly all matches agree with, so far from where it is expected.
bool believed(double off_rad, std::size_t poses_before, double step_rad = 0.05) {
  const auto state = std::make_unique<MapState>();
  ExpectedPose e;
  e.prediction.covariance = 1e-4 * PoseCovariance::Identity();
  e.prediction.rotation_poses = e.poses_since_start = poses_before;
  e.step_rad = step_rad;
  state->localised.absolute.pose.R_CT = so3_exp(off_rad * Eigen::Vector3d::UnitY());
  state->localised.absolute.covariance = 1e-6 * PoseCovariance::Identity();
  state->localised.absolute.inliers = 100;
  state->map.landmarks[0].used = true;
  state->map.landmarks[0].seen_keyframe = state->map.next_keyframe_number;
  state->localised.matches.resize(120);
  for (LandmarkMatch& match : state->localised.matches) {
    match.landmark = LandmarkId::from_index(0);
  }
  return believable(e, false, *state);
}

TEST(Believable, IsWhatAContactCanDo_AndNoFaceThatLooksAlike) {
  constexpr double kHalfTurn_rad = 3.14;
  EXPECT_TRUE(believed(0.1, 20)) << "reversed: two steps";
  EXPECT_TRUE(believed(0.15, 20, 0.001)) << "a slow one that is pushed";
  EXPECT_FALSE(believed(kHalfTurn_rad, 20));
  EXPECT_TRUE(believed(kHalfTurn_rad, 4)) << "a young motion rules out nothing";
}

TEST(MarkInconsistent, MakesThePoseAsUncertainAsItDeviatesFromTheMotion) {
  const auto state = std::make_unique<MapState>();
  PosePrediction predicted;
  predicted.pose.p_CT = {0.0, 0.0, 8.0};
  state->localised.absolute.pose = {.R_CT = so3_exp(0.3 * Eigen::Vector3d::UnitX()),
                                    .p_CT = {0.0, 0.5, 8.0}};
  mark_inconsistent(predicted, state.get());
  EXPECT_NEAR(std::sqrt(state->inconsistency(0, 0)), 0.3, 1e-12);
  EXPECT_NEAR(std::sqrt(state->inconsistency(4, 4)), 0.5, 1e-12);
  begin_frame(state.get());
  EXPECT_TRUE(state->inconsistency.isZero(0.0)) << "of one frame";
}

TEST(LocaliseWithPrior, LooksAsFarAsThePriorsErrorReaches) {
  Bench b(8);
  PosePrediction prior = b.expected(0.0, 0.1).prediction;  // 19 px
  const LocaliseInput input = localise_input(b.input(), b.state->map);
  const auto narrow =
      localise_with_prior(input, prior, &b.state->scratch.localise, &b.state->localised);
  ASSERT_FALSE(narrow.ok());
  EXPECT_EQ(narrow.error().code, ErrorCode::kTooFewObservations);
  prior.covariance.bottomRightCorner<3, 3>() = 0.1 * 0.1 * Eigen::Matrix3d::Identity();
  ASSERT_TRUE(
      localise_with_prior(input, prior, &b.state->scratch.localise, &b.state->localised).ok());
  EXPECT_LT(b.normalised_error2(), 27.9);
}

TEST(LocaliseWithPrior, ReturnsTooFewObservations_WithoutFeatures) {
  Bench b(0);
  const auto unseen = localise_with_prior(localise_input(b.input(), b.state->map),
                                          b.expected(0.0).prediction,
                                          &b.state->scratch.localise,
                                          &b.state->localised);
  ASSERT_FALSE(unseen.ok());
  EXPECT_EQ(unseen.error().code, ErrorCode::kTooFewObservations);
}

}  // namespace
}  // namespace polhode::find_with_prior_test
