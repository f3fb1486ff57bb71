// What another pass has learnt of a body's inertia, as a prior of the fit.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "model_statistics.hpp"
#include "motion/rigid_model.hpp"

namespace polhode::known_body_test {
namespace {

BoundCase tumbling_case(std::size_t frames) {
  return {
      .body = asymmetric_body(3.0 * kDegree_rad), .frames = frames, .interval_s = 2.0, .noise = {}};
}

RigidModel fit(const std::vector<PoseSample>& poses, const KnownBody& known_body = {}) {
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto workspace = std::make_unique<MotionWorkspace>();
  for (const PoseSample& pose : poses) (void)snapshot->poses.push_back(pose);
  snapshot->body_radius = 0.5;
  snapshot->known_body = known_body;
  return fit_rigid_model(*snapshot, *workspace);
}

/// What a model of another pass says of the body.
KnownBody learnt_from(const RigidModel& model) {
  const auto sigmas = model.covariance.diagonal().cwiseSqrt().eval();
  return {.known = true,
          .shape = model.shape,
          .shape_sigma = sigmas.segment<kShapeNumbers>(kRotationUnknowns - kShapeNumbers),
          .mass_centre_T = model.path.tail<3>(),
          .mass_centre_sigma = sigmas.tail<3>()};
}

double error_later(const RigidModel& model, const TruthSample& truth) {
  const auto predicted = predict_motion(model, truth.timestamp_ns);
  return predicted ? rotation_angle_rad(predicted.value().pose.R_CT, truth.pose.R_CT) : 10.0;
}

// 16 poses see 90 deg of the rotation; what they leave open of the inertia another pass has seen.
TEST(KnownBody, IsPredictedBetter_WithinItsSigma) {
  constexpr std::size_t kSeen = 16;
  const BoundCase c = tumbling_case(120);
  const auto truth = tumble(c.body, c.frames, c.interval_s);
  double squares = 0.0;
  double squares_known = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const RigidModel other_pass = fit(observed(truth, c.noise, 100 + seed));
    ASSERT_TRUE(other_pass.accepted() && other_pass.translation_known);
    std::vector<PoseSample> poses = observed(truth, c.noise, seed);
    poses.resize(kSeen);
    const RigidModel known = fit(poses, learnt_from(other_pass));
    ASSERT_TRUE(known.accepted());
    const TruthSample& later = truth[60];  // 270 deg on
    const double error = error_later(known, later);
    squares_known += error * error;
    squares += std::pow(error_later(fit(poses), later), 2);
    const auto predicted = predict_motion(known, later.timestamp_ns);
    EXPECT_LT(error, 3.4 * std::sqrt(predicted.value().covariance.topLeftCorner<3, 3>().trace()))
        << seed;
  }
  EXPECT_LT(squares_known, 0.25 * squares);
}

TEST(KnownBody, OfAnotherShapeIsLeftOutOfTheFit) {
  const BoundCase c = tumbling_case(60);
  const auto truth = tumble(c.body, c.frames, c.interval_s);
  const std::vector<PoseSample> poses = observed(truth, c.noise, 5);
  KnownBody other = learnt_from(fit(poses));
  other.shape = -other.shape;
  other.shape_sigma.setConstant(0.01);
  const RigidModel model = fit(poses, other);
  ASSERT_TRUE(model.accepted());
  EXPECT_EQ(model.shape, fit(poses).shape);
}

}  // namespace
}  // namespace polhode::known_body_test
