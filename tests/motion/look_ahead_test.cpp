#include "motion/look_ahead.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <vector>

#include "free_body.hpp"
#include "geometry/so3.hpp"
#include "motion/body_dynamics.hpp"
#include "motion/fit_poses.hpp"

namespace polhode::look_ahead_test {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180.0;

RigidModel model_of(const Eigen::Vector3d& w_deg_s, std::size_t frames, double interval_s) {
  FreeBody body;
  body.inertia = {0.25, 0.38, 0.47};
  body.R_CT = so3_exp({0.2, -0.4, 0.1});
  body.w_T_rad_s = kDegree_rad * w_deg_s;
  body.v_mass_centre_C = {0.002, -0.001, 0.003};
  auto snapshot = std::make_unique<MotionSnapshot>();
  for (const PoseSample& sample : observed(tumble(body, frames, interval_s), {}, 5)) {
    EXPECT_TRUE(remember_for_fit(snapshot->poses, sample, snapshot->options));
  }
  const auto workspace = std::make_unique<MotionWorkspace>();
  RigidModel model = fit_rigid_model(*snapshot, *workspace);
  EXPECT_TRUE(model.accepted());
  return model;
}

/// Frames that a walk takes, and what it tells on its way.
struct Walked {
  int frames = 0;
  std::vector<MotionPrediction> told;
};

Walked walk_to_the_end(const RigidModel& model, std::int64_t timestamp_ns) {
  auto walk = std::make_unique<LookAhead>();
  EXPECT_TRUE(begin_look_ahead(model, timestamp_ns, walk.get()));
  Walked walked;
  while (walk->under_way && walked.frames < 1000) {
    ++walked.frames;
    if (const auto reached = continue_look_ahead(walk.get())) {
      walked.told.push_back(*reached);
    }
  }
  return walked;
}

class PredictionWalks : public ::testing::TestWithParam<double> {};

TEST_P(PredictionWalks, TellWhatOneIntegrationToThatTimeTells) {
  const RigidModel model = model_of(GetParam() * Eigen::Vector3d(0.3, 0.8, 0.5), 60, 1.0);
  const std::int64_t now_ns = model.reference_ns + 2'000'000'000;
  const Walked walked = walk_to_the_end(model, now_ns);
  ASSERT_EQ(walked.told.size(), kPredictionsAhead_s.size());
  for (std::size_t i = 0; i < walked.told.size(); ++i) {
    const MotionPrediction& told = walked.told[i];
    const std::int64_t then_ns = now_ns + std::llround(1e9 * kPredictionsAhead_s[i]);
    EXPECT_EQ(told.timestamp_ns, then_ns);
    const Result<MotionPrediction> at_once = predict_motion(model, then_ns);
    ASSERT_TRUE(at_once.ok());
    // Both are off by Runge-Kutta's 1e-6 rad in ten turns at most, in steps that do not coincide.
    const double turns = GetParam() * kPredictionsAhead_s[i] / 360.0;
    const double tolerance = 2e-7 * (1.0 + turns);
    EXPECT_LT(rotation_angle_rad(told.pose.R_CT, at_once.value().pose.R_CT), tolerance);
    EXPECT_LT((told.w_T_rad_s - at_once.value().w_T_rad_s).norm(), tolerance);
    EXPECT_LT((told.pose.p_CT - at_once.value().pose.p_CT).norm(), 1e-9 + tolerance);
    EXPECT_LT((told.covariance - at_once.value().covariance).norm(),
              1e-4 * at_once.value().covariance.norm());
  }
}

TEST_P(PredictionWalks, TakeBoundedWorkAFrame) {
  const RigidModel model = model_of(GetParam() * Eigen::Vector3d(0.3, 0.8, 0.5), 60, 1.0);
  const Walked walked = walk_to_the_end(model, model.reference_ns);
  const double steps =
      model.reference.w_T_rad_s.norm() * kPredictionsAhead_s.back() / kRotationStepAngle_rad;
  // A part for every kLookAheadStepsMax steps, and one that ends early for every time that is told.
  EXPECT_LE(walked.frames,
            static_cast<int>(1.2 * steps / kLookAheadStepsMax) +
                static_cast<int>(kPredictionsAhead_s.size()) + 1);
  EXPECT_GE(walked.frames, static_cast<int>(0.8 * steps / kLookAheadStepsMax));
}

INSTANTIATE_TEST_SUITE_P(DegreesASecond, PredictionWalks, ::testing::Values(0.5, 4.0, 25.0));

TEST(LookAhead, OfARefusedModelDoesNotBegin) {
  auto walk = std::make_unique<LookAhead>();
  walk->under_way = true;
  EXPECT_FALSE(begin_look_ahead({}, 1'000, walk.get()));
  EXPECT_FALSE(walk->under_way);
  EXPECT_FALSE(continue_look_ahead(walk.get()).has_value());
}

/// Of the axis that the body turns about, by integration: where it points after a period of the
/// rate, and how often it has gone round the momentum.
double precession_by_integration_s(const Eigen::Vector3d& J, const Eigen::Vector3d& w, int axis) {
  const Inertia inertia{.J_T = J.asDiagonal(), .J_inverse = J.cwiseInverse().asDiagonal()};
  const double period_s = spin_period_s(J.asDiagonal(), w);
  RotationState state{.time_s = 0.0, .R_IT = Eigen::Matrix3d::Identity(), .w_T_rad_s = w};
  const Eigen::Vector3d h_I = J.cwiseProduct(w).normalized();
  const Eigen::Vector3d across = h_I.unitOrthogonal();
  const auto azimuth_rad = [&] {
    const Eigen::Vector3d a = state.R_IT.col(axis);
    return std::atan2(a.dot(h_I.cross(across)), a.dot(across));
  };
  constexpr int kParts = 4000;
  double before_rad = azimuth_rad();
  double round_rad = 0.0;
  for (int i = 1; i <= kParts; ++i) {
    EXPECT_TRUE(advance(inertia, {}, period_s * i / kParts, state, nullptr));
    const double now_rad = azimuth_rad();
    round_rad += std::remainder(now_rad - before_rad, 2.0 * std::numbers::pi);
    before_rad = now_rad;
  }
  return 2.0 * std::numbers::pi * period_s / std::abs(round_rad);
}

TEST(PrecessionPeriod, IsThatOfTheIntegratedMotion_AboutEitherAxis) {
  struct Case {
    Eigen::Vector3d J, w;
    int axis;
  };
  const std::vector<Case> cases{{{0.25, 0.38, 0.47}, {0.02, 0.03, 0.09}, 2},
                                {{0.25, 0.38, 0.47}, {0.09, 0.02, 0.03}, 0},
                                {{0.10, 0.44, 0.47}, {0.30, 0.10, 0.02}, 0},
                                {{0.40, 0.42, 0.80}, {0.01, 0.20, 0.05}, 2},
                                {{0.25, 0.38, 0.47}, {0.012, 0.09, 0.017}, 2}};
  for (const Case& c : cases) {
    const double by_integration_s = precession_by_integration_s(c.J, c.w, c.axis);
    EXPECT_NEAR(
        precession_period_s(c.J.asDiagonal(), c.w), by_integration_s, 1e-5 * by_integration_s)
        << c.J.transpose() << " / " << c.w.transpose();
  }
}

}  // namespace
}  // namespace polhode::look_ahead_test
