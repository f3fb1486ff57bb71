#include "solve/bundle_system.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "solve/cauchy_loss.hpp"

namespace polhode {
namespace {

constexpr double kSigma = 1e-3;
constexpr double kCauchySigma = 2.0;

Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

/// Four poses, twelve points, each seen in every pose with 1 sigma of noise. The first pose is
/// held.
struct Scene {
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> pose_fixed{1, 0, 0, 0};
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> point_fixed;
  std::vector<BundleObservation> observations;
  std::vector<PosePrior> priors;
  std::unique_ptr<BundleWorkspace> workspace = std::make_unique<BundleWorkspace>();

  explicit Scene(double noise_sigmas = 1.0) {
    Rng rng(3, 17);
    for (int k = 0; k < 4; ++k) {
      poses.push_back(to_inverse_depth(
          {.R_CT = so3_exp({0.02 * k, 0.2 * k, 0.0}), .p_CT = {0.1 * k, 0.0, 10.0}}));
    }
    for (int i = 0; i < 12; ++i) {
      points_T.push_back(normal3(&rng).normalized());
      point_fixed.push_back(0);
      for (int k = 0; k < 4; ++k) {
        BundleObservation o{.pose = k, .point = i, .sigma_normalised = kSigma};
        EXPECT_TRUE(reproject(poses[static_cast<std::size_t>(k)], points_T.back(), &o.normalised));
        o.normalised += noise_sigmas * kSigma * Eigen::Vector2d(rng.normal(), rng.normal());
        observations.push_back(o);
      }
    }
  }

  void hold_points() { point_fixed.assign(points_T.size(), 1); }
  BundleProblem problem() {
    return {.poses = poses,
            .pose_fixed = pose_fixed,
            .points_T = points_T,
            .point_fixed = point_fixed,
            .observations = observations,
            .priors = priors};
  }
};

/// The poses with the k-th of the unknowns moved: six for each pose but the first.
std::vector<InverseDepthPose> moved(std::vector<InverseDepthPose> poses, int k, double step) {
  InverseDepthPose& pose = poses[static_cast<std::size_t>(1 + k / 6)];
  const Eigen::Vector3d by = step * Eigen::Vector3d::Unit(k % 3);
  if (k % 6 < 3) {
    pose.R_CT = so3_exp(by) * pose.R_CT;
  } else {
    pose.uvs += by;
  }
  return poses;
}

TEST(BundleSystem, CostIsHalfTheRobustSumOfSquares) {
  Scene s(0.0);
  s.observations[0].normalised.x() += 3.0 * kSigma;
  s.observations[7].normalised.y() -= kSigma;
  const BundleProblem problem = s.problem();
  const BundleSystem system(problem, kCauchySigma, s.workspace.get());
  const double expected = cauchy_loss(9.0, kCauchySigma) + cauchy_loss(1.0, kCauchySigma);
  EXPECT_NEAR(system.cost(), 0.5 * expected, 1e-9);
  EXPECT_EQ(system.size(), 18);
}

TEST(BundleSystem, CostOfAPointBehindACameraIsInfinite) {
  Scene s;
  s.points_T[5] = {0.0, 0.0, -20.0};
  const BundleProblem problem = s.problem();
  const BundleSystem system(problem, kCauchySigma, s.workspace.get());
  EXPECT_TRUE(std::isinf(system.cost()));
}

TEST(BundleSystem, PriorCostsWhatThePoseDepartsFromIt) {
  Scene s(0.0);
  PosePrior prior{.pose = 2, .mean = s.poses[2]};
  prior.information.setIdentity();
  prior.mean.uvs.x() -= 3.0;  // 3 sigma
  s.priors.push_back(prior);
  const BundleProblem problem = s.problem();
  const BundleSystem system(problem, kCauchySigma, s.workspace.get());
  EXPECT_NEAR(system.cost(), 0.5 * cauchy_loss(9.0, 4.0), 1e-9);
}

TEST(BundleSystem, RightSideIsTheDownhillGradient_OfObservationsAndPriors) {
  Scene s;
  s.hold_points();
  // At the pose itself, where the derivative of the departure is exact.
  PosePrior prior{.pose = 1, .mean = s.poses[1]};
  prior.information = 1e4 * Eigen::Matrix<double, 6, 6>::Identity();
  prior.mean.uvs.y() += 0.01;
  PosePrior of_held = prior;  // counts, and pulls at nothing
  of_held.pose = 0;
  s.priors = {of_held, prior};
  const BundleProblem problem = s.problem();
  BundleSystem system(problem, kCauchySigma, s.workspace.get());
  system.build(0.0);
  for (int k = 0; k < 18; ++k) {
    constexpr double kStep = 1e-6;
    const double slope = (system.cost(moved(s.poses, k, kStep), s.points_T) -
                          system.cost(moved(s.poses, k, -kStep), s.points_T)) /
                         (2.0 * kStep);
    EXPECT_NEAR(system.step()(k), -slope, 1e-4 * (1.0 + std::abs(slope))) << k;
  }
}

TEST(BundleSystem, StepByTheReducedSystemGainsWhatItPromises) {
  Scene s;
  const BundleProblem problem = s.problem();
  constexpr double kDamping = 1e-3;
  BundleSystem system(problem, 1e6, s.workspace.get());  // squares: the model is nearly exact
  system.build(kDamping);
  system.step() = system.reduced().selfadjointView<Eigen::Lower>().ldlt().solve(system.step());
  ASSERT_TRUE(system.move_poses());
  const double promised = system.move_points(kDamping);
  EXPECT_GT(promised, 0.0);
  EXPECT_NEAR(system.cost() - system.trial_cost(), promised, 0.05 * promised);
  const double reached = system.trial_cost();
  system.keep_trial();
  EXPECT_EQ(system.cost(), reached);
}

TEST(BundleSystem, OneStepBringsADisturbedSceneNearlyBack) {
  Scene s(0.0);
  Rng rng(4, 2);
  for (std::size_t k = 1; k < s.poses.size(); ++k) {
    s.poses[k].R_CT = so3_exp(0.01 * normal3(&rng)) * s.poses[k].R_CT;
  }
  for (Eigen::Vector3d& p_T : s.points_T) p_T += 0.01 * normal3(&rng);
  const BundleProblem problem = s.problem();
  BundleSystem system(problem, 1e6, s.workspace.get());
  system.build(1e-9);
  system.step() = system.reduced().selfadjointView<Eigen::Lower>().ldlt().solve(system.step());
  ASSERT_TRUE(system.move_poses());
  (void)system.move_points(1e-9);
  // Second order in a hundredth of the extent.
  EXPECT_LT(system.trial_cost(), 0.01 * system.cost());
}

TEST(BundleSystem, LeavesAloneWhatIsHeldAndWhatNothingSees) {
  Scene s;
  s.point_fixed[3] = 1;
  std::erase_if(s.observations, [](const BundleObservation& o) { return o.pose == 2; });
  const Scene before;
  const BundleProblem problem = s.problem();
  BundleSystem system(problem, kCauchySigma, s.workspace.get());
  system.build(1e-3);
  EXPECT_EQ(system.reduced()(6, 6), 1.0);  // the second of the moving poses sees nothing
  system.step() = system.reduced().selfadjointView<Eigen::Lower>().ldlt().solve(system.step());
  ASSERT_TRUE(system.move_poses());
  (void)system.move_points(1e-3);
  system.keep_trial();
  EXPECT_EQ(s.poses[0].R_CT, before.poses[0].R_CT);
  EXPECT_EQ(s.poses[2].uvs, before.poses[2].uvs);
  EXPECT_EQ(s.points_T[3], before.points_T[3]);
  EXPECT_NE(s.poses[1].uvs, before.poses[1].uvs);
  EXPECT_NE(s.points_T[4], before.points_T[4]);
}

TEST(BundleSystem, RefusesAStepThatMakesDepthNegative) {
  Scene s;
  const BundleProblem problem = s.problem();
  BundleSystem system(problem, kCauchySigma, s.workspace.get());
  system.step().setZero();
  EXPECT_TRUE(system.move_poses());
  system.step()(5) = -2.0 * s.poses[1].uvs.z();
  EXPECT_FALSE(system.move_poses());
}

TEST(BundleSystem, SettlesPointsWhereTheTrialsPosesWantThem) {
  Scene s(0.0);
  const std::vector<Eigen::Vector3d> truth = s.points_T;
  Rng rng(5, 1);
  for (Eigen::Vector3d& p_T : s.points_T) p_T += 0.02 * normal3(&rng);
  s.point_fixed[0] = 1;
  const BundleProblem problem = s.problem();
  BundleSystem system(problem, 1e6, s.workspace.get());
  system.step().setZero();
  ASSERT_TRUE(system.move_poses());
  const double before = system.cost();
  const double after = system.settle_points();
  EXPECT_LT(after, before);
  EXPECT_EQ(after, system.trial_cost());
  system.keep_trial();
  EXPECT_GT((s.points_T[0] - truth[0]).norm(), 1e-3);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    // Two Gauss-Newton steps from 0.03: quadratic convergence leaves next to nothing.
    EXPECT_LT((s.points_T[i] - truth[i]).norm(), 1e-3) << i;
  }
}

/// Steps towards the bottom of 1 + x^2 / 2 that go `factor` times as far as Newton's.
struct Parabola {
  double x = 1.0;
  double trial = 0.0;
  double factor = 1.0;

  static double cost(double at) { return 1.0 + 0.5 * at * at; }
  BundleReport run(int iterations_max) {
    return take_damped_steps(
        cost(x),
        iterations_max,
        1e-3,
        [this](double damping) {
          trial = x - factor * x / (1.0 + damping);
          return 0.5 * x * x;
        },
        [this] { return cost(trial); },
        [this] { x = trial; });
  }
};

TEST(DampedSteps, GoDownhillAndEndWhereNothingMoves) {
  Parabola parabola;
  const BundleReport report = parabola.run(50);
  EXPECT_TRUE(report.usable);
  EXPECT_LT(std::abs(parabola.x), 1e-5);
  EXPECT_EQ(report.cost_before, 1.5);
  EXPECT_EQ(report.cost_after, Parabola::cost(parabola.x));
  EXPECT_LT(report.iterations, 5);
}

TEST(DampedSteps, KeepNoStepThatGoesUphill_AndDampUntilOneGoesDown) {
  Parabola parabola{.factor = 3.0};  // lands at -2 x
  EXPECT_EQ(parabola.run(1).cost_after, 1.5);
  EXPECT_EQ(parabola.x, 1.0);
  EXPECT_LT(parabola.run(40).cost_after, 1.001);
}

TEST(DampedSteps, KeepTheirCount_AndStopWithoutAStep) {
  Parabola parabola{.factor = 0.1};
  EXPECT_EQ(parabola.run(3).iterations, 3);
  EXPECT_EQ(parabola.run(0).iterations, 0);
  int kept = 0;
  const BundleReport none = take_damped_steps(
      1.0, 1000, 1e-3, [](double) { return -1.0; }, [] { return 0.0; }, [&kept] { ++kept; });
  EXPECT_EQ(kept, 0);
  EXPECT_EQ(none.cost_after, 1.0);
  EXPECT_LT(none.iterations, 20);  // ever larger factors: soon too small to matter
}

TEST(DampedSteps, OfACostThatIsNotFiniteAreNotUsable) {
  for (const double cost :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const BundleReport report = take_damped_steps(
        cost, 10, 1e-3, [](double) { return 1.0; }, [] { return 0.0; }, [] {});
    EXPECT_FALSE(report.usable);
    EXPECT_EQ(report.iterations, 0);
  }
}

}  // namespace
}  // namespace polhode
