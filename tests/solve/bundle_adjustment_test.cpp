#include "solve/bundle_adjustment.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "base/rng.hpp"
#include "bundle_scene.hpp"
#include "geometry/so3.hpp"
#include "solve/settle_points.hpp"

namespace polhode::bundle_adjustment_test {
namespace {

using testing::disturbed;
using testing::make_scene;
using Scene = testing::BundleScene;

constexpr double kSigma = testing::kBundleSigma;
// The solver ends where a step gains less than 5e-5 of the cost. Weights are those of the last
// step, so an error falls by a part each time: it leaves up to twice that gain, and a half more.
constexpr double kSettled = 1.5e-4;
// The loss of every residual here is its square to ten digits: statistics are those of squares.
constexpr double kWide = 1e6;

double worst_error(const Scene& a, const Scene& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.poses.size(); ++k) {
    worst = std::max(worst, rotation_angle_rad(a.poses[k].R_CT, b.poses[k].R_CT));
    worst = std::max(worst, (a.poses[k].uvs - b.poses[k].uvs).norm());
  }
  for (std::size_t i = 0; i < a.points_T.size(); ++i) {
    worst = std::max(worst, (a.points_T[i] - b.points_T[i]).norm());
  }
  return worst;
}

bool same_bytes(const Scene& a, const Scene& b) {
  for (std::size_t k = 0; k < a.poses.size(); ++k) {
    if (a.poses[k].R_CT != b.poses[k].R_CT || a.poses[k].uvs != b.poses[k].uvs) {
      return false;
    }
  }
  return a.points_T == b.points_T;
}

// verifies: MAP-07
TEST(AdjustBundle, FindsTheScene_WhenItWasDisturbed) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Scene truth = make_scene(6, 60, 0.0, seed);
    Scene s = disturbed(truth, seed);
    const BundleReport report = adjust_bundle(s.problem(), {.iterations_max = 50});
    ASSERT_TRUE(report.usable);
    EXPECT_LT(report.cost_after, 1e-6 * report.cost_before);
    // Exact images: the last steps are quadratic and end where rounding of the images (1e-16 over
    // the parallax of 0.1) or a cost of 1e-8 sigma squared is met.
    EXPECT_LT(worst_error(s, truth), 1e-6) << seed;
  }
}

TEST(AdjustBundle, EndsWhereItEndsFromTheTruth_WhenTheImagesAreNoisy) {
  const Scene truth = make_scene(6, 60, 1.0, 3);
  Scene from_truth = truth;
  Scene from_afar = disturbed(truth, 3);
  const BundleReport a = adjust_bundle(from_truth.problem(), {.iterations_max = 50});
  const BundleReport b = adjust_bundle(from_afar.problem(), {.iterations_max = 50});
  ASSERT_TRUE(a.usable && b.usable);
  EXPECT_LE(a.cost_after, a.cost_before);
  EXPECT_NEAR(b.cost_after, a.cost_after, 1e-3 * a.cost_after);
  // A point is seen six times with half a milliradian at a distance of 10 and a spread of views of
  // 0.9 rad: some 5 mm in its worst direction, and the same again from the poses; five sigma of
  // that.
  EXPECT_LT(worst_error(from_afar, truth), 0.05);
}

TEST(AdjustBundle, DoesNotMoveWhatIsHeld) {
  const Scene truth = make_scene(5, 40, 1.0, 4);
  Scene s = disturbed(truth, 4);
  for (std::size_t i = 0; i < 10; ++i) {
    s.point_fixed[i] = 1;
    s.points_T[i] = truth.points_T[i];
  }
  ASSERT_TRUE(adjust_bundle(s.problem(), {.iterations_max = 10}).usable);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(s.poses[k].R_CT, truth.poses[k].R_CT);
    EXPECT_EQ(s.poses[k].uvs, truth.poses[k].uvs);
  }
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(s.points_T[i], truth.points_T[i]);
  }
}

TEST(AdjustBundle, IsNotPulledAway_ByAFewWrongImages) {
  const Scene truth = make_scene(6, 60, 1.0, 5);
  Scene s = truth;
  for (std::size_t i = 0; i < s.observations.size(); i += 23) {
    s.observations[i].normalised += Eigen::Vector2d(40.0 * kSigma, -30.0 * kSigma);
  }
  Scene clean = truth;
  ASSERT_TRUE(adjust_bundle(clean.problem(), {.iterations_max = 50}).usable);
  ASSERT_TRUE(adjust_bundle(s.problem(), {.iterations_max = 50}).usable);
  // At 50 sigma a Cauchy loss of 2 sigma leaves a pull of c^2 / r = 0.08 sigma: unseen beside five
  // other images of the point, while least squares would move it by 50 / 6 sigma, some 40 mm.
  EXPECT_LT(worst_error(s, clean), 0.02);
}

TEST(AdjustBundle, GoesFromAFarStart_WhereItGoesFromANearOne) {
  // Residuals of a dozen sigma, of which the loss leaves a thirtieth: a step that takes the loss's
  // own curvature there overshoots.
  for (const int poses : {6, 48}) {
    for (std::uint64_t seed = 50; seed < 56; ++seed) {
      const Scene truth = make_scene(poses, 60, 1.0, seed);
      Scene near = disturbed(truth, seed, 0.1);
      Scene far = disturbed(truth, seed, 2.0);
      const BundleReport of_near = adjust_bundle(near.problem(), {.iterations_max = 50});
      const BundleReport of_far = adjust_bundle(far.problem(), {.iterations_max = 10});
      ASSERT_TRUE(of_near.usable && of_far.usable);
      EXPECT_GT(of_far.cost_before, 10.0 * of_near.cost_after);
      EXPECT_NEAR(of_far.cost_after, of_near.cost_after, kSettled * of_near.cost_after)
          << poses << " poses, seed " << seed;
    }
  }
}

TEST(AdjustBundle, StopsAtItsLimitOfIterations_WithWhatItKept) {
  // A hundred sigma have nearly their full weight, and sums of losses still resolve 1e-10.
  constexpr double kNearlyWide = 1e3;
  const Scene start = disturbed(make_scene(6, 60, 1.0, 3), 3, 18.0);
  // With full weights and from so far some trials go uphill: what is reported and left is never a
  // trial that was not kept.
  int uphill = 0;
  int iterations = 0;
  double kept = std::numeric_limits<double>::infinity();
  for (int limit = 1; limit < 10; ++limit) {
    Scene s = start;
    const BundleReport report =
        adjust_bundle(s.problem(), {.iterations_max = limit, .cauchy_sigma = kNearlyWide});
    // It ends at the limit, or where it converged: from there on a higher limit changes nothing.
    EXPECT_TRUE(report.iterations == limit || report.iterations == iterations) << limit;
    iterations = report.iterations;
    EXPECT_LE(report.cost_after, report.cost_before);
    EXPECT_NEAR(bundle_cost(s.problem(), kNearlyWide), report.cost_after, 1e-9 * report.cost_after);
    uphill += report.cost_after == kept ? 1 : 0;
    kept = report.cost_after;
  }
  EXPECT_GT(uphill, 0);
  EXPECT_GE(iterations, 5);  // most of the limits were met before it converged
}

TEST(AdjustBundle, LeavesTheProblemUntouched_WithoutObservations) {
  Scene s = make_scene(3, 10, 0.0, 7);
  s.observations.clear();
  const Scene before = s;
  EXPECT_FALSE(adjust_bundle(s.problem(), {}).usable);
  EXPECT_TRUE(same_bytes(s, before));
}

// verifies: MAP-07
TEST(AdjustBundle, LeavesTheProblemUntouched_WhenAValueIsNotFinite) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Scene good = disturbed(make_scene(4, 20, 1.0, 8), 8);
  Scene image = good;
  image.observations[17].normalised.x() = kNaN;
  EXPECT_FALSE(adjust_bundle(image.problem(), {}).usable);
  EXPECT_TRUE(same_bytes(image, good));
  Scene point = good;
  point.points_T[3].x() = kNaN;
  EXPECT_FALSE(adjust_bundle(point.problem(), {}).usable);
  EXPECT_EQ(point.points_T[4], good.points_T[4]);
  EXPECT_EQ(point.poses[3].uvs, good.poses[3].uvs);
}

TEST(AdjustBundle, LeavesTheProblemUntouched_WhenAPointLiesBehindACamera) {
  const Scene good = disturbed(make_scene(4, 20, 1.0, 9), 9);
  Scene s = good;
  s.points_T[5] = {0.0, 0.0, -20.0};
  const Scene before = s;
  EXPECT_FALSE(adjust_bundle(s.problem(), {}).usable);
  EXPECT_TRUE(same_bytes(s, before));
}

TEST(AdjustBundle, CountsAPointThatOnePoseSeesTwice) {
  const Scene truth = make_scene(5, 40, 0.0, 12);
  Scene s = disturbed(truth, 12);
  std::vector<BundleObservation> twice;
  for (const BundleObservation& o : s.observations) {
    twice.push_back(o);
    if (o.point % 3 == 0) {
      twice.push_back(o);
    }
  }
  s.observations = twice;
  ASSERT_TRUE(adjust_bundle(s.problem(), {.iterations_max = 50}).usable);
  EXPECT_LT(worst_error(s, truth), 1e-6);
}

TEST(AdjustBundle, LeavesAPoseThatSeesNothing) {
  const Scene truth = make_scene(6, 40, 0.0, 13);
  Scene s = disturbed(truth, 13);
  std::erase_if(s.observations, [](const BundleObservation& o) { return o.pose == 4; });
  const InverseDepthPose before = s.poses[4];
  ASSERT_TRUE(adjust_bundle(s.problem(), {.iterations_max = 50}).usable);
  EXPECT_EQ(s.poses[4].R_CT, before.R_CT);
  EXPECT_EQ(s.poses[4].uvs, before.uvs);
}

TEST(AdjustBundle, CostsTheSame_WhereverTheGaugeIsHeld) {
  for (std::uint64_t seed = 30; seed < 35; ++seed) {
    const Scene start = disturbed(make_scene(6, 60, 1.0, seed), seed, 0.1);
    Scene free = start;
    free.pose_fixed.assign(6, 0);
    Scene one = start;
    one.pose_fixed = {0, 0, 0, 1, 0, 0};
    const BundleReport of_free = adjust_bundle(free.problem(), {.iterations_max = 50});
    const BundleReport of_one = adjust_bundle(one.problem(), {.iterations_max = 50});
    ASSERT_TRUE(of_free.usable && of_one.usable);
    EXPECT_NEAR(of_one.cost_after, of_free.cost_after, kSettled * of_free.cost_after) << seed;
    // Two poses hold twelve unknowns, the gauge has seven: held where the free adjustment put
    // them, the rest goes to the same minimum.
    Scene two = free;
    two.pose_fixed = {1, 0, 0, 0, 0, 1};
    two = disturbed(two, seed, 0.1);
    const BundleReport of_two = adjust_bundle(two.problem(), {.iterations_max = 50});
    EXPECT_GT(of_two.cost_before, 1.1 * of_two.cost_after);
    EXPECT_NEAR(of_two.cost_after, of_free.cost_after, kSettled * of_free.cost_after) << seed;
  }
}

/// Information of the last pose, the inverse of its part of the covariance of all that is free.
Eigen::Matrix<double, 6, 6> last_pose_information(const Scene& truth) {
  const auto of_points = 3 * static_cast<Eigen::Index>(truth.points_T.size());
  const Eigen::Index unknowns = of_points + 6 * (static_cast<Eigen::Index>(truth.poses.size()) - 2);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (const BundleObservation& o : truth.observations) {
    LinearisedObservation l;
    const InverseDepthPose& pose = truth.poses[static_cast<std::size_t>(o.pose)];
    const Eigen::Vector3d& p_T = truth.points_T[static_cast<std::size_t>(o.point)];
    EXPECT_TRUE(linearise(o, pose, p_T, kWide, &l));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, unknowns);
    if (o.pose >= 2) J.middleCols<6>(of_points + 6 * (o.pose - 2)) = l.by_pose;
    J.middleCols<3>(3 * o.point) = l.by_point;
    information += J.transpose() * J;
  }
  const Eigen::MatrixXd covariance = information.inverse();
  return covariance.bottomRightCorner<6, 6>().inverse();
}

TEST(AdjustBundle, ErrorsAreThoseOfTheNoise) {
  // A mean's standard error is 7 % of one number's scatter.
  constexpr int kSeeds = 200;
  // 5 x 12 x 2 numbers of images less 3 poses of 6 and 12 points of 3.
  constexpr double kFreedom = 120.0 - 18.0 - 36.0;
  const Scene exact = make_scene(5, 12, 0.0, 40);
  const Eigen::Matrix<double, 6, 6> information = last_pose_information(exact);
  double mean_cost = 0.0;
  double mean_square = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Scene s = disturbed(exact, seed, 0.1);
    Rng rng(seed, 83);
    for (BundleObservation& o : s.observations) {
      o.normalised += kSigma * Eigen::Vector2d(rng.normal(), rng.normal());
    }
    const BundleReport report =
        adjust_bundle(s.problem(), {.iterations_max = 50, .cauchy_sigma = kWide});
    ASSERT_TRUE(report.usable);
    Eigen::Matrix<double, 6, 1> error;
    error << so3_log(s.poses[4].R_CT * exact.poses[4].R_CT.transpose()),
        s.poses[4].uvs - exact.poses[4].uvs;
    mean_cost += 2.0 * report.cost_after / kSeeds;
    mean_square += error.dot(information * error) / kSeeds;
  }
  // Chi-squares of f numbers have a variance of 2 f; three standard errors of the mean.
  EXPECT_NEAR(mean_cost, kFreedom, 3.0 * std::sqrt(2.0 * kFreedom / kSeeds));
  EXPECT_NEAR(mean_square, 6.0, 3.0 * std::sqrt(2.0 * 6.0 / kSeeds));
}

// verifies: MAP-07
TEST(AdjustBundle, GivesTheSameBytes_EachTimeAndAtAnyAddress) {
  const Scene start = disturbed(make_scene(8, 50, 1.0, 14), 14, 0.2);
  Scene expected = start;
  const BundleReport report = adjust_bundle(expected.problem(), {});
  ASSERT_TRUE(report.usable);
  // A point has 24 bytes: every second shift puts the points off the 16 that packets want.
  for (std::size_t shift = 0; shift < 5; ++shift) {
    Scene s = start;
    s.observations.reserve(s.observations.size() + 1000 * shift);
    std::vector<Eigen::Vector3d> points_T(s.points_T.size() + 4);
    std::vector<InverseDepthPose> poses(s.poses.size() + 4);
    const std::span shifted_T = std::span(points_T).subspan(shift, s.points_T.size());
    const std::span shifted = std::span(poses).subspan(shift, s.poses.size());
    std::copy(s.points_T.begin(), s.points_T.end(), shifted_T.begin());
    std::copy(s.poses.begin(), s.poses.end(), shifted.begin());
    BundleProblem problem = s.problem();
    problem.points_T = shifted_T;
    problem.poses = shifted;
    EXPECT_EQ(adjust_bundle(problem, {}).cost_after, report.cost_after) << shift;
    s.points_T.assign(shifted_T.begin(), shifted_T.end());
    s.poses.assign(shifted.begin(), shifted.end());
    EXPECT_TRUE(same_bytes(s, expected)) << shift;
  }
}

TEST(AdjustBundle, FindsThePoses_WhenAllPointsAreHeld) {
  const Scene truth = make_scene(6, 30, 0.0, 15);
  Scene s = truth;
  s.point_fixed.assign(30, 1);
  s = disturbed(s, 15, 0.2);
  ASSERT_TRUE(adjust_bundle(s.problem(), {.iterations_max = 50}).usable);
  EXPECT_EQ(s.points_T, truth.points_T);
  EXPECT_LT(worst_error(s, truth), 1e-6);
}

TEST(AdjustBundle, GoesWhereEachPointSettles_WhenAllPosesAreHeld) {
  for (const double noise_sigmas : {0.0, 1.0}) {
    const Scene truth = make_scene(6, 30, noise_sigmas, 16);
    Scene s = truth;
    s.pose_fixed.assign(6, 1);
    s = disturbed(s, 16, 0.2);
    Scene settled = truth;
    const BundleReport report = adjust_bundle(s.problem(), {.iterations_max = 50});
    ASSERT_TRUE(report.usable);
    const double least = settle_points(settled.problem(), {.iterations_max = 50});
    EXPECT_NEAR(report.cost_after, least, kSettled * least + 1e-12);
    EXPECT_NEAR(report.cost_after, bundle_cost(s.problem(), 2.0), 1e-9);  // rounding of images
    EXPECT_TRUE(noise_sigmas > 0.0 || worst_error(s, truth) < 1e-6);
    EXPECT_TRUE(s.poses[5].R_CT == truth.poses[5].R_CT && s.poses[5].uvs == truth.poses[5].uvs);
  }
}

TEST(AdjustBundle, HandlesManyPoses_AsWellAsFew) {
  const Scene truth = make_scene(48, 30, 0.0, 11);
  Scene s = disturbed(truth, 11);
  ASSERT_TRUE(adjust_bundle(s.problem(), {.iterations_max = 30}).usable);
  EXPECT_LT(worst_error(s, truth), 1e-5);
}

TEST(BundleAdjustment, APriorHoldsWhatTheImagesLeaveOpen) {
  // All observations of the last pose are gone but two: they leave directions open in which the
  // prior decides.
  const Scene truth = make_scene(5, 40, 0.0, 21);
  Scene s = disturbed(truth, 22);
  std::erase_if(s.observations,
                [](const BundleObservation& o) { return o.pose == 4 && o.point > 1; });
  BundleProblem problem = s.problem();
  std::vector<PosePrior> priors{{.pose = 4, .mean = truth.poses[4]}};
  priors[0].information.diagonal().setConstant(1e8);  // 1e-4
  problem.priors = priors;
  ASSERT_TRUE(adjust_bundle(problem, {.iterations_max = 40}).usable);
  EXPECT_LT(rotation_angle_rad(s.poses[4].R_CT, truth.poses[4].R_CT), 1e-4);
  EXPECT_LT((s.poses[4].uvs - truth.poses[4].uvs).norm(), 1e-4);
}

TEST(BundleAdjustment, APriorThatIsFarOffLosesItsPull) {
  const Scene truth = make_scene(5, 40, 0.0, 23);
  Scene s = truth;
  BundleProblem problem = s.problem();
  std::vector<PosePrior> priors{{.pose = 4, .mean = truth.poses[4]}};
  priors[0].mean.R_CT = so3_exp({0.0, 0.1, 0.0}) * priors[0].mean.R_CT;
  priors[0].information.diagonal().setConstant(1e6);  // 0.1 rad is 100 sigma
  problem.priors = priors;
  ASSERT_TRUE(adjust_bundle(problem, {.iterations_max = 40}).usable);
  EXPECT_LT(rotation_angle_rad(s.poses[4].R_CT, truth.poses[4].R_CT), 0.01)
      << "of the 0.1 that it is off";
}

}  // namespace
}  // namespace polhode::bundle_adjustment_test
