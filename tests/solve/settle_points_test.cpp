#include "solve/settle_points.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::settle_points_test {
namespace {

/// Cauchy's loss of a squared residual.
double cauchy_loss(double error2, double width) {
  return width * width * std::log1p(error2 / (width * width));
}

// Of images a tenth of a radian wide.
constexpr double kSigma = 1e-3;
// The default of BundleOptions.
constexpr double kCauchySigma = 2.0;
// Far more than a point needs: steps end by themselves when the cost no longer falls.
constexpr int kManySteps = 50;

Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

/// Four poses ten radii off that look at twelve points from 0.6 rad in all; every pose sees every
/// point.
struct Scene {
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> pose_fixed = std::vector<std::uint8_t>(4, 0);
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> point_fixed = std::vector<std::uint8_t>(12, 0);
  std::vector<BundleObservation> observations;

  explicit Scene(double noise_sigmas) {
    Rng rng(3, 17);
    for (int k = 0; k < 4; ++k) {
      poses.push_back(to_inverse_depth(
          {.R_CT = so3_exp({0.02 * k, 0.2 * k, 0.0}), .p_CT = {0.1 * k, 0.0, 10.0}}));
    }
    for (int i = 0; i < 12; ++i) {
      points_T.push_back(normal3(&rng).normalized());
      for (int k = 0; k < 4; ++k) {
        BundleObservation o{.pose = k, .point = i, .sigma_normalised = kSigma};
        EXPECT_TRUE(reproject(poses[static_cast<std::size_t>(k)], points_T.back(), &o.normalised));
        o.normalised += noise_sigmas * kSigma * Eigen::Vector2d(rng.normal(), rng.normal());
        observations.push_back(o);
      }
    }
  }

  void disturb(double by, std::uint64_t seed) {
    Rng rng(seed, 18);
    for (Eigen::Vector3d& p_T : points_T) p_T += by * normal3(&rng);
  }
  BundleProblem problem() {
    return {.poses = poses,
            .pose_fixed = pose_fixed,
            .points_T = points_T,
            .point_fixed = point_fixed,
            .observations = observations};
  }
  double cost() { return bundle_cost(problem(), kCauchySigma); }
  double settle(int steps_max = kManySteps) {
    return settle_points(problem(), {.iterations_max = steps_max, .cauchy_sigma = kCauchySigma});
  }
};

TEST(PointObservations, HoldEachObservationOnceInItsOrder) {
  std::vector<BundleObservation> observations;
  for (const std::int32_t point : {4, 1, 4, 2, 1, 4}) {
    const auto pose = static_cast<std::int32_t>(observations.size());
    observations.push_back({.pose = pose, .point = point});
  }
  const PointObservations by_point(observations, 6);
  const std::vector<std::vector<std::int32_t>> expected{{}, {1, 4}, {3}, {}, {0, 2, 5}, {}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::vector<std::int32_t> poses;
    for (const BundleObservation& o : by_point.of(i)) {
      EXPECT_EQ(o.point, static_cast<std::int32_t>(i));
      poses.push_back(o.pose);
    }
    EXPECT_EQ(poses, expected[i]) << i;
  }
  EXPECT_TRUE(PointObservations({}, 1).of(0).empty());
}

TEST(Linearise, GivesResidualDerivativesAndWeight_InSigma) {
  // Of central differences: square of the step and rounding over it, both 1e-11 times 1e3 a sigma.
  constexpr double kStep = 1e-5;
  const Scene s(3.0);
  const BundleObservation& o = s.observations[6];
  const InverseDepthPose& pose = s.poses[2];
  const Eigen::Vector3d& p_T = s.points_T[1];
  LinearisedObservation at;
  ASSERT_TRUE(linearise(o, pose, p_T, kCauchySigma, &at));
  Eigen::Vector2d image;
  ASSERT_TRUE(reproject(pose, p_T, &image));
  EXPECT_LT((kSigma * at.residual + o.normalised - image).norm(), 1e-15);
  EXPECT_NEAR(at.weight, 1.0 / (1.0 + at.residual.squaredNorm() / 4.0), 1e-15);
  const auto by_all = (Eigen::Matrix<double, 2, 9>() << at.by_pose, at.by_point).finished();
  for (int k = 0; k < 9; ++k) {
    std::array<LinearisedObservation, 2> ends;
    for (const std::size_t end : {0U, 1U}) {
      const Eigen::Vector3d by = (end == 0 ? -kStep : kStep) * Eigen::Vector3d::Unit(k % 3);
      InverseDepthPose moved = pose;
      if (k < 3) moved.R_CT = so3_exp(by) * pose.R_CT;
      if (k / 3 == 1) moved.uvs += by;
      const Eigen::Vector3d moved_T = p_T + (k < 6 ? 0.0 : 1.0) * by;
      ASSERT_TRUE(linearise(o, moved, moved_T, kCauchySigma, &ends[end]));
    }
    const Eigen::Vector2d slope = 0.5 / kStep * (ends[1].residual - ends[0].residual);
    EXPECT_LT((by_all.col(k) - slope).norm(), 1e-7 * (1.0 + at.by_pose.norm())) << k;
  }
}

TEST(DampedInverse, IsTheInverseOfAMatrixWithPartsOfItsDiagonalAdded) {
  const Eigen::Matrix3d diagonal = Eigen::Vector3d(2.0, 4.0, 8.0).asDiagonal();
  const Eigen::Matrix3d halved = Eigen::Vector3d(0.25, 0.125, 0.0625).asDiagonal();
  EXPECT_LT((damped_inverse(diagonal, 1.0) - halved).norm(), 1e-15);
  const Eigen::Matrix3d R = so3_exp({0.5, -0.4, 0.8});
  const Eigen::Matrix3d V = R * diagonal * R.transpose();
  // Off by the damping over the least eigenvalue, at most twice for the largest diagonal element.
  EXPECT_LT((damped_inverse(V, 1e-9) * V - Eigen::Matrix3d::Identity()).norm(), 1e-8);
}

TEST(DampedInverse, IsZeroOfZero_AndFiniteWhereADirectionIsOpen) {
  EXPECT_TRUE(damped_inverse(Eigen::Matrix3d::Zero(), 1e-6).isZero(0.0));
  const Eigen::Matrix3d flat = Eigen::Vector3d(4.0, 1.0, 0.0).asDiagonal();
  const Eigen::Matrix3d turned_by = so3_exp({0.5, -0.4, 0.8});
  for (const Eigen::Matrix3d& R : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turned_by}) {
    const Eigen::Matrix3d V = R * flat * R.transpose();
    const Eigen::Matrix3d inverse = damped_inverse(V, 1e-6);
    EXPECT_TRUE(inverse.allFinite());
    // In the two determined directions, the inverse to the damping, twice its largest part.
    EXPECT_LT((V * inverse * V - V).norm(), 1e-5);
  }
}

TEST(BundleCost, IsHalfTheRobustSumOfSquares) {
  Scene s(0.0);
  EXPECT_LT(s.cost(), 1e-20);  // images to 1e-16, over sigma and squared
  s.observations[0].normalised.x() += 3.0 * kSigma;
  s.observations[7].normalised.y() -= kSigma;
  s.observations[9].normalised.y() -= kSigma;
  s.observations[9].sigma_normalised = 0.5 * kSigma;
  // Residuals of 3, 1 and 2 sigma.
  const double expected = 0.5 * (cauchy_loss(9.0, kCauchySigma) + cauchy_loss(1.0, kCauchySigma) +
                                 cauchy_loss(4.0, kCauchySigma));
  EXPECT_NEAR(s.cost(), expected, 1e-11);
}

TEST(BundleCost, IsInfinite_WhereAPointThatIsSeenLiesBehindACamera) {
  Scene s(1.0);
  s.points_T[5] = {0.0, 0.0, -20.0};
  EXPECT_TRUE(std::isinf(s.cost()));
  std::erase_if(s.observations, [](const BundleObservation& o) { return o.point == 5; });
  EXPECT_TRUE(std::isfinite(s.cost()));
}

TEST(SettlePoints, BringsDisturbedPointsBack_ToWhereExactImagesPutThem) {
  const Scene truth(0.0);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene s(0.0);
    s.disturb(0.03, seed);
    EXPECT_GT(s.cost(), 1.0);
    EXPECT_LT(s.settle(), 1e-13);  // the resolution of the sums of logarithms, below
    for (std::size_t i = 0; i < truth.points_T.size(); ++i) {
      // 1 + e / 4 resolves no square below 1e-15: residuals of 3e-8 sigma, and a sigma is 0.01
      // radii across the line of sight; along it thrice that for views of 0.3 rad to either side.
      EXPECT_LT((s.points_T[i] - truth.points_T[i]).norm(), 2e-9) << seed << ' ' << i;
    }
  }
}

TEST(SettlePoints, BringsPointsBackInAFewSteps) {
  // The loss of three sigma is their square to a thousandth: steps are Newton's.
  constexpr double kNearlyWide = 100.0;
  const Scene truth(0.0);
  Scene s(0.0);
  s.disturb(0.03, 1);
  const PointObservations by_point(s.observations, s.points_T.size());
  for (std::size_t i = 0; i < s.points_T.size(); ++i) {
    (void)settle_point(by_point.of(i), s.poses, kNearlyWide, 3, &s.points_T[i]);
    // An error of 0.05 is a part of 0.005 of the distance, and each step leaves so much of it: its
    // third power, times 0.05, and ten for the weak direction.
    EXPECT_LT((s.points_T[i] - truth.points_T[i]).norm(), 1e-7) << i;
  }
}

TEST(SettlePoints, GivesTheCostOfTheBundle) {
  for (const int steps_max : {0, 1, 2, kManySteps}) {
    Scene s(1.0);
    s.disturb(0.05, 2);
    s.point_fixed[3] = 1;
    const double cost = s.settle(steps_max);
    // Logarithms of products of other factors: rounding of a sum of 48 terms.
    EXPECT_NEAR(cost, s.cost(), 1e-13 * cost) << steps_max;
  }
}

TEST(SettlePoints, EndsWhereNoSmallMoveOfAPointCostsLess) {
  Scene s(1.0);
  s.disturb(0.03, 4);
  const double least = s.settle();
  for (std::size_t i = 0; i < s.points_T.size(); ++i) {
    for (int k = 0; k < 6; ++k) {
      // A tenth of the 1e-2 that a sigma is here: felt, and within the hollow.
      Scene moved = s;
      moved.points_T[i](k % 3) += k < 3 ? 1e-3 : -1e-3;
      EXPECT_GT(moved.cost(), least) << i << ' ' << k;
    }
  }
}

TEST(SettlePoints, NeverRaisesTheCost_HoweverFarThePointsAreOff) {
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Scene start(1.0);
    // Up to near the cameras: there a Gauss-Newton step may go uphill, or behind one.
    start.disturb(4.0, seed);
    const PointObservations by_point(start.observations, start.points_T.size());
    for (std::size_t i = 0; i < start.points_T.size(); ++i) {
      double least = std::numeric_limits<double>::infinity();
      for (int steps_max = 0; steps_max < 5; ++steps_max) {
        Eigen::Vector3d p_T = start.points_T[i];
        const double cost =
            settle_point(by_point.of(i), start.poses, kCauchySigma, steps_max, &p_T);
        const double kept = settle_point(by_point.of(i), start.poses, kCauchySigma, 0, &p_T);
        ASSERT_LE(cost, least);
        ASSERT_EQ(cost, kept);  // of where it left the point
        refused += cost == least && std::isfinite(cost) ? 1 : 0;
        least = cost;
      }
    }
  }
  EXPECT_GT(refused, 0);  // else no step was tried that rises
}

TEST(SettlePoints, DoesNotMoveFixedPointsOrThoseThatNothingSees) {
  Scene s(1.0);
  s.disturb(0.03, 5);
  s.point_fixed[0] = 1;
  std::erase_if(s.observations, [](const BundleObservation& o) { return o.point == 1; });
  const std::vector<Eigen::Vector3d> before = s.points_T;
  (void)s.settle();
  EXPECT_EQ(s.points_T[0], before[0]);
  EXPECT_EQ(s.points_T[1], before[1]);
  for (std::size_t i = 2; i < before.size(); ++i) {
    EXPECT_NE(s.points_T[i], before[i]) << i;
  }
}

TEST(SettlePoints, PutsAPointOntoTheRayOfItsOnlyImage_AndKeepsItsDepth) {
  Scene s(1.0);
  std::erase_if(s.observations, [](const BundleObservation& o) { return o.pose != 2; });
  s.disturb(0.01, 6);
  const std::vector<Eigen::Vector3d> before = s.points_T;
  EXPECT_LT(s.settle(), 1e-9);
  for (std::size_t i = 0; i < before.size(); ++i) {
    // Ten radii off a sigma is 0.01: noise and what the point was disturbed by, five of each.
    EXPECT_LT((s.points_T[i] - before[i]).norm(), 0.1) << i;
  }
}

TEST(SettlePoints, IsNotPulledAwayByAWrongImage) {
  const Scene truth(0.0);
  Scene s(0.0);
  s.observations[2].normalised.x() += 100.0 * kSigma;
  s.disturb(0.03, 7);
  (void)s.settle();
  // The loss leaves 2^2 / 100 sigma of pull beside three images of a sigma, 0.01, each: some
  // 0.04 / 3 of it; the worst direction has a tenth of the parallax. Squares would give 0.3.
  EXPECT_LT((s.points_T[0] - truth.points_T[0]).norm(), 2e-3);
}

TEST(SettlePoints, LeavesAPointBehindACameraAsItWas) {
  Scene s(1.0);
  const Eigen::Vector3d behind_T(0.0, 0.0, -20.0);
  s.points_T[5] = behind_T;
  EXPECT_TRUE(std::isinf(s.settle()));
  EXPECT_EQ(s.points_T[5], behind_T);
  s.point_fixed[5] = 1;
  EXPECT_TRUE(std::isinf(s.settle()));
}

}  // namespace
}  // namespace polhode::settle_points_test
