#include "motion/rigid_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "model_statistics.hpp"
#include "motion/fit_poses.hpp"

namespace polhode::rigid_model_test {
namespace {

/// The paper's body with its transverse moments a little apart, so that every axis can be told, and
/// its mass centre off T's origin.
BoundCase paper_case(std::size_t frames) {
  BoundCase c{.body = paper_body(), .frames = frames, .interval_s = 10.0, .noise = {}};
  c.body.inertia = {0.45, 0.47, 0.02};
  c.body.mass_centre_T = {0.02, 0.01, -0.03};
  return c;
}

BoundCase tumbling_case(std::size_t frames) {
  return {
      .body = asymmetric_body(3.0 * kDegree_rad), .frames = frames, .interval_s = 2.0, .noise = {}};
}

RigidModel fit(const std::vector<PoseSample>& poses,
               const PoseCovariance& drift = PoseCovariance::Zero(),
               const MotionOptions& options = {}) {
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto workspace = std::make_unique<MotionWorkspace>();
  for (const PoseSample& pose : poses) (void)snapshot->poses.push_back(pose);
  snapshot->drift = drift;
  snapshot->body_radius = 0.5;
  snapshot->options = options;
  return fit_rigid_model(*snapshot, *workspace);
}

void expect_consistent(const BoundCase& c, int seeds) {
  const ModelStatistics s = run_seeds(c, seeds);
  const Compared bound = cramer_rao(c);
  EXPECT_GE(s.accepted, 0.9 * seeds);
  double inside = 0.0;
  for (int k = 0; k < kCompared; ++k) {
    EXPECT_LT(s.rms(k), 2.0 * bound(k)) << k;
    EXPECT_LT(s.sigma(k), 10.0 * s.rms(k)) << k;
    inside += s.inside(k) / kCompared;
  }
  // 95 % of seeds x 14 numbers, of which about five are independent: three standard deviations.
  EXPECT_GT(inside, 0.95 - 3.0 * std::sqrt(0.05 * 0.95 / (5.0 * seeds)));
}

// verifies: MOT-05, MOT-12
TEST(RigidModel, OfThePapersCaseReachesTheBoundWithHonestSigmas) {
  expect_consistent(paper_case(150), 12);
}

TEST(RigidModel, OfASheetIsNotMadeThickByWhatWasHeldBeforehand) {
  // The second moment across the sheet is zero; over 300 poses the prior would make it several
  // sigmas.
  const BoundCase c = paper_case(300);
  const Eigen::Vector3d& J = c.body.inertia;
  ASSERT_NEAR(J(0) + J(2), J(1), 1e-12);
  expect_consistent(c, 12);
}

// verifies: MOT-05
TEST(RigidModel, OfATumblingBodyReachesTheBoundWithHonestSigmas) {
  expect_consistent(tumbling_case(120), 12);
}

TEST(RigidModel, FindsTheNoiseWhenItIsDeclaredTooLarge) {
  const ModelStatistics s = run_seeds(tumbling_case(120), 6, 3.0);
  EXPECT_EQ(s.accepted, 6);
  for (int k = 0; k < kCompared; ++k) EXPECT_LT(s.sigma(k), 4.0 * s.rms(k)) << k;
}

TEST(RigidModel, RefusesPosesThatAreFarNoisierThanTheySay) {
  const ModelStatistics s = run_seeds(tumbling_case(60), 3, 0.3);
  EXPECT_EQ(s.accepted, 0);
}

// verifies: MOT-08
TEST(RigidModel, RefusesTimesThatAreNotThePoses) {
  // A turntable moved by hand: attitudes of a steady turn, at steps that vary by a fifth.
  Rng rng(7, 1);
  std::vector<PoseSample> poses;
  double angle = 0.0;
  for (int i = 0; i < 47; ++i) {
    PoseSample pose{.timestamp_ns = i * 1'000'000'000LL, .pose = {}};
    pose.pose = {.R_CT = so3_exp({0.0, angle, 0.0}), .p_CT = {0.0, 0.0, 5.0}};
    pose.covariance.diagonal() << 4e-6, 4e-6, 4e-6, 1e-6, 1e-6, 1e-4;
    poses.push_back(pose);
    angle += 0.134 * (1.0 + 0.2 * rng.normal());
  }
  const RigidModel model = fit(poses);
  EXPECT_FALSE(model.accepted());
  EXPECT_FALSE(predict_motion(model, 0).ok());
}

TEST(RigidModel, HoldsOutAgainstWrongPosesAndGaps) {
  const BoundCase c = tumbling_case(120);
  const auto truth = tumble(c.body, c.frames, c.interval_s);
  std::vector<PoseSample> poses = observed(truth, c.noise, 3);
  for (std::size_t i = 5; i < poses.size(); i += 17) {
    poses[i].pose.R_CT = so3_exp({0.4, -0.3, 0.2}) * poses[i].pose.R_CT;
    poses[i].pose.p_CT.x() += 0.5;
  }
  poses.erase(poses.begin() + 60, poses.begin() + 85);
  const RigidModel model = fit(poses);
  ASSERT_TRUE(model.accepted());
  EXPECT_GE(model.attitude.outliers, 5U);
  const Compared error = errors_of(model, c.body, truth.back());
  const Compared sigma = sigmas_of(model);
  for (int k = 0; k < kCompared; ++k) EXPECT_LT(std::abs(error(k)), 4.5 * sigma(k)) << k;
}

TEST(RigidModel, FollowsTheLaterPartWhenAPushLiesBefore) {
  const BoundCase c = tumbling_case(60);
  FreeBody pushed = c.body;
  pushed.w_T_rad_s = Eigen::Vector3d(0.02, -0.01, 0.03);
  std::vector<PoseSample> poses = observed(tumble(c.body, 40, 2.0), c.noise, 1);
  const std::vector<TruthSample> later = tumble(pushed, 80, 2.0);
  for (PoseSample pose : observed(later, c.noise, 2)) {
    pose.timestamp_ns += 80'000'000'000;
    poses.push_back(pose);
  }
  const RigidModel model = fit(poses);
  ASSERT_TRUE(model.accepted());
  EXPECT_EQ(model.poses, 60U);
  EXPECT_LT((model.reference.w_T_rad_s - later.back().w_T_rad_s).norm(), 1e-4);
}

// verifies: MOT-07
TEST(RigidModel, OfAPureSpinClaimsNeitherInertiaNorTheMassCentreOnItsAxis) {
  FreeBody body;
  body.inertia = {0.42, 0.40, 0.24};
  body.w_T_rad_s = {0.0, 0.0, 3.0 * kDegree_rad};
  body.R_CT = so3_exp({0.7, 0.2, 0.0});
  body.mass_centre_T = {0.05, 0.02, 0.08};
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const RigidModel model = fit(observed(tumble(body, 100, 2.0), {}, seed));
    ASSERT_TRUE(model.accepted());
    const BodyDynamics d = describe_dynamics(model).value();
    EXPECT_NE(d.largest_over_least.observability, Observability::kObserved);
    EXPECT_EQ(d.spin_period_s.observability, Observability::kUnobserved);
    EXPECT_EQ(d.rotation_period_s.observability, Observability::kObserved);
    EXPECT_NEAR(d.rotation_period_s.value, 120.0, 0.05);
    EXPECT_EQ(d.mass_centre[0].observability, Observability::kObserved);
    EXPECT_EQ(d.mass_centre[1].observability, Observability::kObserved);
    EXPECT_EQ(d.mass_centre[2].observability, Observability::kUnobserved);
    EXPECT_GT(std::abs(d.mass_centre_axes_T(2, 2)), 0.999);
  }
}

TEST(RigidModel, OfABodyOfRevolutionClaimsNoTransverseAxes) {
  FreeBody body = paper_body();
  const RigidModel model = fit(observed(tumble(body, 200, 10.0), {}, 2));
  ASSERT_TRUE(model.accepted());
  const BodyDynamics d = describe_dynamics(model).value();
  EXPECT_EQ(d.axes[0], Observability::kObserved);  // the long axis
  EXPECT_GT(std::abs(d.R_TP(2, 0)), 0.999);
  EXPECT_NE(d.axes[1], Observability::kObserved);
  EXPECT_NE(d.axes[2], Observability::kObserved);
  EXPECT_EQ(d.largest_over_least.observability, Observability::kObserved);
  // Nutation in the body at (1 - 0.02 / 0.47) deg/s; the momentum's axis is circled at h / 0.47.
  EXPECT_NEAR(d.spin_period_s.value, 376.0, 0.2);
  const double momentum = std::hypot(0.47 * 0.1, 0.02 * 1.0);
  EXPECT_NEAR(
      d.precession_period_s.value, 360.0 / (momentum / 0.47), 5.0 * d.precession_period_s.sigma);
}

TEST(RigidModel, RatiosWithoutASlopeKeepHonestSigmas) {
  // The axes of the two least moments may be turned about the third: at the best fit the ratios do
  // not change with that in the first order, and bodies within its sigmas have others.
  constexpr int kDraws = 400;
  RigidModel model;
  model.status = ModelStatus::kAccepted;
  model.reference.w_T_rad_s = {0.01, 0.05, 0.02};
  model.shape = shape_of(Eigen::Vector3d(1.0, 1.1, 1.7).asDiagonal());
  InertiaShape sigma = InertiaShape::Constant(0.005);
  for (int k = 0; k < 5; ++k) sigma(k) = std::abs(shape_basis(k)(0, 1)) > 0.1 ? 0.2 : sigma(k);
  ASSERT_EQ(sigma.maxCoeff(), 0.2);
  model.covariance = 1e-10 * ModelCovariance::Identity();
  model.covariance.block<5, 5>(6, 6) = sigma.cwiseAbs2().asDiagonal();
  const BodyDynamics d = describe_dynamics(model).value();
  const std::array<Estimated, 2> ratios{d.middle_over_least, d.largest_over_least};
  Rng rng(3, 1);
  std::array<int, 2> inside{};
  std::array<double, 2> error2{};
  for (int draw = 0; draw < kDraws; ++draw) {
    InertiaShape body = model.shape;
    for (int k = 0; k < 5; ++k) body(k) += sigma(k) * rng.normal();
    const Eigen::Vector3d moments =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia_of(body).J_T, Eigen::EigenvaluesOnly)
            .eigenvalues();
    for (std::size_t k = 0; k < 2; ++k) {
      const double error = ratios[k].value - moments(static_cast<Eigen::Index>(k) + 1) / moments(0);
      inside[k] += std::abs(error) < 1.96 * ratios[k].sigma ? 1 : 0;
      error2[k] += error * error / kDraws;
    }
  }
  for (std::size_t k = 0; k < 2; ++k) {
    // Errors go as the square of a Gaussian, whose mean and scatter together are sqrt(3): 1.96 of
    // that hold 93.4 % of them. Three standard deviations of so many draws below.
    constexpr double kHeld = 0.934;
    EXPECT_GT(inside[k], (kHeld - 3.0 * std::sqrt(kHeld * (1.0 - kHeld) / kDraws)) * kDraws) << k;
    EXPECT_LT(ratios[k].sigma * ratios[k].sigma, 4.0 * error2[k]) << k;
  }
}

TEST(RigidModel, OfABodyAtRestKnowsThatAndNothingOfItsInside) {
  const RigidModel model = fit(observed(tumble(FreeBody{}, 60, 1.0), {}, 2));
  ASSERT_TRUE(model.accepted());
  const BodyDynamics d = describe_dynamics(model).value();
  EXPECT_LT(model.reference.w_T_rad_s.norm(),
            5.0 * worst_sigma(model.covariance.block<3, 3>(3, 3)));
  EXPECT_EQ(d.largest_over_least.observability, Observability::kUnobserved);
  EXPECT_EQ(d.rotation_period_s.observability, Observability::kUnobserved);
  EXPECT_EQ(d.spin_period_s.observability, Observability::kUnobserved);
  for (const Estimated& one : d.mass_centre)
    EXPECT_EQ(one.observability, Observability::kUnobserved);
}

TEST(RigidModel, OfTooFewOrUnusablePosesSaysSo) {
  const std::vector<PoseSample> poses = observed(tumble(paper_body(), 12, 10.0), {}, 1);
  EXPECT_EQ(fit({}).status, ModelStatus::kTooFewPoses);
  EXPECT_EQ(fit({poses.begin(), poses.begin() + 2}).status, ModelStatus::kTooFewPoses);
  std::vector<PoseSample> bad = poses;
  bad[4].covariance.setZero();
  EXPECT_EQ(fit(bad).status, ModelStatus::kNoFit);
  bad[4].covariance.setConstant(std::nan(""));
  EXPECT_EQ(fit(bad).status, ModelStatus::kNoFit);
  EXPECT_FALSE(describe_dynamics(fit(bad)).ok());
}

TEST(RigidModel, IsTheSameFromTheSamePosesAndNearlyFromAWarmStart) {
  const std::vector<PoseSample> poses = observed(tumble(tumbling_case(1).body, 80, 2.0), {}, 5);
  const RigidModel first = fit(poses);
  const RigidModel again = fit(poses);
  ASSERT_TRUE(first.accepted());
  EXPECT_EQ(first.reference.R_IT, again.reference.R_IT);
  EXPECT_EQ(first.covariance, again.covariance);
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto workspace = std::make_unique<MotionWorkspace>();
  for (const PoseSample& pose : poses) (void)snapshot->poses.push_back(pose);
  snapshot->body_radius = 0.5;
  snapshot->previous = first;
  const RigidModel warm = fit_rigid_model(*snapshot, *workspace);
  EXPECT_LT((warm.reference.w_T_rad_s - first.reference.w_T_rad_s).norm(),
            0.05 * std::sqrt(first.covariance(3, 3)));
}

TEST(RigidModel, WidensByTheDriftThatPosesShare) {
  const std::vector<PoseSample> poses = observed(tumble(tumbling_case(1).body, 80, 2.0), {}, 5);
  PoseCovariance drift = PoseCovariance::Zero();
  drift.diagonal().setConstant(1e-6);
  const RigidModel alone = fit(poses);
  const RigidModel shared = fit(poses, drift);
  ASSERT_TRUE(alone.accepted() && shared.accepted());
  EXPECT_GT(shared.covariance(3, 3), 2.0 * alone.covariance(3, 3));
}

// verifies: MOT-06
TEST(RigidModel, PredictsTenMinutesAheadWithHonestSigmas) {
  const BoundCase c = paper_case(200);
  const auto truth = tumble(c.body, 261, 10.0);
  int beyond = 0;
  constexpr int kSeeds = 8;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<PoseSample> poses =
        observed({truth.begin(), truth.begin() + 200}, c.noise, seed);
    const RigidModel model = fit(poses);
    ASSERT_TRUE(model.accepted());
    const auto at = predict_motion(model, truth[259].timestamp_ns);
    ASSERT_TRUE(at.ok());
    const Eigen::Vector3d error = so3_log(truth[259].pose.R_CT * at.value().pose.R_CT.transpose());
    EXPECT_LT(error.norm(), 0.5 * kDegree_rad);
    const Eigen::Vector3d p = truth[259].pose.p_CT - at.value().pose.p_CT;
    const PoseCovariance& C = at.value().covariance;
    beyond += error.dot(C.topLeftCorner<3, 3>().ldlt().solve(error)) > 7.81 ? 1 : 0;
    beyond += p.dot(C.bottomRightCorner<3, 3>().ldlt().solve(p)) > 7.81 ? 1 : 0;
  }
  EXPECT_LE(beyond, 4);  // 0.8 of 16 expected
}

TEST(RigidModel, MovedThereAndBackIsTheSame) {
  const RigidModel model = fit(observed(tumble(tumbling_case(1).body, 60, 2.0), {}, 1));
  ASSERT_TRUE(model.accepted());
  RigidModel moved = model;
  ASSERT_TRUE(move_reference(model.reference_ns - 90'000'000'000, moved));
  ASSERT_TRUE(move_reference(model.reference_ns, moved));
  EXPECT_LT(rotation_angle_rad(moved.reference.R_IT, model.reference.R_IT), 1e-6);
  EXPECT_LT((moved.path - model.path).norm(), 1e-9);
  for (int k = 0; k < kModelUnknownsAll; ++k) {
    EXPECT_NEAR(moved.covariance(k, k) / model.covariance(k, k), 1.0, 1e-3);
  }
}

TEST(RigidModel, FitsAnOrbitWhereThatIsTheDynamics) {
  // 900 s: gravity gradient and Hill's terms are far beyond the noise.
  const Inertia inertia = inertia_of(shape_of(Eigen::Vector3d(0.47, 0.40, 0.12).asDiagonal()));
  const Orbit orbit{.mean_motion_rad_s = 0.0011, .R_IH = so3_exp({0.2, 0.5, -0.1})};
  const Eigen::Vector3d c_T(0.03, -0.02, 0.04);
  Eigen::Matrix<double, 6, 1> path;
  path << 0.5, -0.3, 12.0, 0.002, 0.001, -0.004;
  RotationState state;
  state.w_T_rad_s = Eigen::Vector3d(0.2, 0.6, 0.5) * kDegree_rad;
  std::vector<TruthSample> truth;
  for (int i = 0; i < 150; ++i) {
    ASSERT_TRUE(advance(inertia, orbit, 6.0 * i, state, nullptr));
    const Eigen::Vector3d centre = (translation_transition(orbit, 0.0, 6.0 * i) * path).head<3>();
    truth.push_back({.timestamp_ns = i * 6'000'000'000LL,
                     .pose = {.R_CT = state.R_IT, .p_CT = centre - state.R_IT * c_T},
                     .w_T_rad_s = state.w_T_rad_s,
                     .v_C = Eigen::Vector3d::Zero()});
  }
  const std::vector<PoseSample> poses = observed(truth, {}, 4);
  const Eigen::Quaterniond q(orbit.R_IH);
  MotionOptions options;
  options.dynamics = DynamicsKind::kOrbit;
  options.q_IH_w = q.w();
  options.q_IH_x = q.x();
  options.q_IH_y = q.y();
  options.q_IH_z = q.z();
  const RigidModel model = fit(poses, PoseCovariance::Zero(), options);
  ASSERT_TRUE(model.accepted());
  EXPECT_EQ(model.poses, 150U);
  EXPECT_LT(model.position.chi2_per_dof, 1.4);
  const Eigen::Vector3d off = model.reference.w_T_rad_s - truth.back().w_T_rad_s;
  EXPECT_LT(off.norm(), 4.0 * worst_sigma(model.covariance.block<3, 3>(3, 3)));
  EXPECT_LT((model.path.tail<3>() - c_T).norm(),
            4.0 * worst_sigma(model.covariance.bottomRightCorner<3, 3>()));
  // Free of torque the same poses do not pass as a whole.
  const RigidModel free = fit(poses);
  EXPECT_FALSE(free.accepted() && free.poses == 150U);
}

TEST(FitPoses, KeepTheirSpanInABoundedNumber) {
  auto poses = std::make_unique<PoseHistory>();
  MotionOptions options;
  options.fit_poses_max = 64;
  for (std::int64_t i = 0; i < 10'000; ++i) {
    ASSERT_TRUE(remember_for_fit(*poses, {.timestamp_ns = i, .pose = {}}, options));
    ASSERT_LE(poses->size(), 64U);
  }
  EXPECT_EQ((*poses)[0].timestamp_ns, 0);
  EXPECT_EQ(poses->back().timestamp_ns, 9999);
  for (std::size_t i = 1; i < poses->size(); ++i) {
    EXPECT_LT((*poses)[i - 1].timestamp_ns, (*poses)[i].timestamp_ns);
  }
  EXPECT_FALSE(remember_for_fit(*poses, {.timestamp_ns = 9999, .pose = {}}, options));
}

TEST(FitPoses, SpanABoundedNumberOfTurns) {
  for (const double step_rad : {0.002, 0.17}) {  // 10,000 steps: 3 turns, 270 turns
    auto poses = std::make_unique<PoseHistory>();
    for (std::int64_t i = 0; i < 10'000; ++i) {
      const Pose pose{.R_CT = so3_exp({0.0, step_rad * static_cast<double>(i), 0.0}),
                      .p_CT = {0.0, 0.0, 10.0}};
      ASSERT_TRUE(remember_for_fit(*poses, {.timestamp_ns = i * 1'000'000'000, .pose = pose}, {}));
    }
    const double turns = step_rad *
                         seconds_between((*poses)[0].timestamp_ns, poses->back().timestamp_ns) /
                         (2.0 * std::numbers::pi);
    const double turns_of_all = step_rad * 9999.0 / (2.0 * std::numbers::pi);
    const double turns_of_a_table = step_rad * 300.0 / (2.0 * std::numbers::pi);
    EXPECT_LE(turns, kFitTurnsMax + turns_of_a_table);
    EXPECT_GE(turns, std::min(turns_of_all, kFitTurnsMax - turns_of_a_table) - 1e-9);
  }
}

TEST(FitPoses, ForgetWhatIsTooOld) {
  auto poses = std::make_unique<PoseHistory>();
  MotionOptions options;
  options.forgetting_s = 10.0;
  for (std::int64_t i = 0; i < 100; ++i) {
    ASSERT_TRUE(remember_for_fit(*poses, {.timestamp_ns = i * 1'000'000'000, .pose = {}}, options));
  }
  EXPECT_EQ((*poses)[0].timestamp_ns, 89'000'000'000);
}

}  // namespace
}  // namespace polhode::rigid_model_test
