#include "app/smoothed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "../motion/free_body.hpp"
#include "pipeline/state.hpp"

namespace polhode::platform::smoothed_test {
namespace {

constexpr std::size_t kFrames = 60;
constexpr double kInterval_s = 10.0;
constexpr double kSigma95 = 2.7955;  // norm of three unit normal numbers

/// A run over a tumbling body: poses as measured, none in the first frames and in a gap.
class Smoothed : public testing::Test {
 protected:
  Smoothed()
      : state_(std::make_unique<Component::State>()),
        truth_(tumble(asymmetric_body(0.015), kFrames, kInterval_s)) {
    samples_ = observed(truth_, noise_, 3);
    for (std::size_t i = 0; i < kFrames; ++i) {
      const bool valid = i >= 3 && (i < 30 || i >= 35);
      poses_.push_back({.valid = valid, .absolute = {.pose = samples_[i].pose}, .matches = 40});
      published_.push_back(
          {.frame = static_cast<std::uint32_t>(i), .timestamp_ns = truth_[i].timestamp_ns});
    }
    for (std::size_t i = kFrames; i-- > 0;) {
      if (!poses_[i].valid) {
        samples_.erase(samples_.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }

  [[nodiscard]] std::vector<MotionState> rows(const RigidModel& model) const {
    return smoothed_motion(
        {poses_, samples_, published_}, model, ServicerAttitude(), view_of(*state_));
  }

  [[nodiscard]] RigidModel model() const { return model_of(samples_, 1.0, view_of(*state_)); }

  [[nodiscard]] double attitude_error_rad(const MotionState& m) const {
    const Eigen::Quaterniond q(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]);
    return rotation_angle_rad(q.toRotationMatrix(), truth_[m.frame].pose.R_CT);
  }

  [[nodiscard]] double position_error(const MotionState& m) const {
    return (Eigen::Vector3d(m.p_CT[0], m.p_CT[1], m.p_CT[2]) - truth_[m.frame].pose.p_CT).norm();
  }

  std::unique_ptr<Component::State> state_;
  std::vector<TruthSample> truth_;
  PoseNoise noise_{.attitude_rad = {1e-2, 1e-2, 3e-3}, .position = {1e-3, 1e-3, 3e-2}};
  std::vector<PoseSample> samples_;
  std::vector<SmoothedPose> poses_;
  std::vector<MotionState> published_;
};

// verifies: MOT-11
TEST_F(Smoothed, EveryFrameHasThePoseOfTheDynamics_WithSigmasThatHoldItsError) {
  const RigidModel fitted = model();
  ASSERT_TRUE(fitted.accepted());
  std::size_t inside = 0;
  double square_rad2 = 0.0;
  for (const MotionState& m : rows(fitted)) {
    ASSERT_TRUE(m.pose_valid && m.rate_valid && m.velocity_valid) << m.frame;
    EXPECT_EQ(m.matches, poses_[m.frame].valid ? 40 : 0);
    // The body's own sigma of the noise is 1e-2 rad and 3e-2: the dynamics must be surer than
    // single poses.
    EXPECT_LT(m.sigma_att_rad, 0.7e-2) << m.frame;
    EXPECT_LT(m.sigma_pos, 2e-2) << m.frame;
    inside += attitude_error_rad(m) < kSigma95 * m.sigma_att_rad &&
                      position_error(m) < kSigma95 * m.sigma_pos
                  ? 1
                  : 0;
    square_rad2 += attitude_error_rad(m) * attitude_error_rad(m);
  }
  EXPECT_GE(inside, kFrames * 9 / 10);
  // 52 poses to 11 unknowns: a part of sqrt(11 / 156) of the noise remains, 0.38e-2 rad; twice
  // that.
  EXPECT_LT(std::sqrt(square_rad2 / kFrames), 0.76e-2);
}

TEST_F(Smoothed, MeasuredPosesStand_WhereNoModelIsAccepted) {
  std::size_t next = 0;
  for (const MotionState& m : rows(RigidModel())) {
    ASSERT_EQ(m.pose_valid, poses_[m.frame].valid) << m.frame;
    if (m.pose_valid) {
      const Eigen::Quaterniond q(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]);
      EXPECT_LT(rotation_angle_rad(q.toRotationMatrix(), samples_[next].pose.R_CT), 1e-9);
      EXPECT_EQ(m.p_CT[2], samples_[next].pose.p_CT.z());
      ++next;
    }
  }
}

TEST_F(Smoothed, AModelOfTheLaterPosesDoesNotSpeakOfMuchEarlierFrames) {
  const RigidModel later = model_of(std::span(samples_).last(20), 1.0, view_of(*state_));
  ASSERT_TRUE(later.accepted());
  const std::vector<MotionState> all = rows(later);
  EXPECT_FALSE(all[0].pose_valid);
  EXPECT_FALSE(all[32].pose_valid);
  // A tenth of 190 s before the first of its poses, which is that of frame 40.
  EXPECT_EQ(all[38].p_CT[2], samples_[38 - 8].pose.p_CT.z());
  EXPECT_NE(all[39].p_CT[2], samples_[39 - 8].pose.p_CT.z());
}

TEST_F(Smoothed, AModelDoesNotLeadBackOverTheEndOfAnEarlierMap) {
  for (std::size_t i : {0, 1}) {
    published_[i].pose_valid = true;
    published_[i].target_frame = view_of(*state_).target_frame + 1;
  }
  const std::vector<MotionState> all = rows(model());
  EXPECT_FALSE(all[0].pose_valid || all[1].pose_valid);
  EXPECT_TRUE(all[2].pose_valid);

  // Poses found with the map of now on the other side show that there is no break.
  published_[31].pose_valid = true;
  published_[31].target_frame = view_of(*state_).target_frame + 1;
  EXPECT_TRUE(rows(model())[31].pose_valid);
}

TEST_F(Smoothed, AModelThatManyPosesContradictGivesRatesOnly) {
  RigidModel contradicted = model();
  ASSERT_TRUE(contradicted.accepted());
  contradicted.attitude.outliers = 5;  // of 52
  const std::vector<MotionState> all = rows(contradicted);
  EXPECT_FALSE(all[0].pose_valid);
  EXPECT_EQ(all[40].p_CT[2], samples_[40 - 8].pose.p_CT.z());
  EXPECT_TRUE(all[40].rate_valid);
}

TEST_F(Smoothed, LengthsInMetresCarryTheErrorOfTheScale) {
  const RigidModel fitted = model();
  const std::vector<MotionState> exact = rows(fitted);
  state_->scale.known = true;
  state_->scale.relative_sigma = 0.02;
  for (const MotionState& m : rows(fitted)) {
    const MotionState& before = exact[m.frame];
    const double p = Eigen::Vector3d(m.p_CT[0], m.p_CT[1], m.p_CT[2]).norm();
    const double v = Eigen::Vector3d(m.v_C[0], m.v_C[1], m.v_C[2]).norm();
    // Both errors in one direction at most, across each other at least.
    EXPECT_GE(m.sigma_pos, 0.02 * p * (1.0 - 1e-9));
    EXPECT_LE(m.sigma_pos, std::hypot(0.02 * p, before.sigma_pos) * (1.0 + 1e-9));
    EXPECT_GE(m.sigma_vel, 0.02 * v * (1.0 - 1e-9));
    EXPECT_LE(m.sigma_vel, std::hypot(0.02 * v, before.sigma_vel) * (1.0 + 1e-9));
    EXPECT_EQ(m.sigma_att_rad, before.sigma_att_rad);
  }
}

TEST_F(Smoothed, AModelThatIsNotSureOfItsAttitudeWritesNothing) {
  RigidModel unsure = model();
  ASSERT_TRUE(unsure.accepted());
  unsure.covariance.topLeftCorner<3, 3>() += 0.01 * Eigen::Matrix3d::Identity();  // 5.7 deg
  EXPECT_FALSE(rows(unsure)[0].pose_valid);
}

TEST_F(Smoothed, TheMapsOwnModelStands_WhereTheSamplesLieOnIt) {
  RigidModel own = model();
  ASSERT_TRUE(own.accepted());
  own.of_map = true;
  state_->motion.model = own;
  EXPECT_FALSE(motion_is_of_map(*state_)) << "the last adjustment did not confirm it";
  state_->jobs.adjustment.as_free_body = true;
  state_->jobs.adjustment.model = own;
  EXPECT_TRUE(motion_is_of_map(*state_));
  const BodyFrame body{.R_TB = so3_exp({0.2, -0.4, 0.1}), .centroid_T = {0.1, 0.0, -0.2}};
  std::vector<PoseSample> in_body = samples_;
  for (PoseSample& sample : in_body) {
    sample.pose.p_CT += sample.pose.R_CT * body.centroid_T;
    sample.pose.R_CT = sample.pose.R_CT * body.R_TB;
  }
  const std::optional<RigidModel> found = model_of_map(in_body, body, view_of(*state_));
  ASSERT_TRUE(found);
  const auto at = predict_motion(*found, in_body[20].timestamp_ns);
  const auto before = predict_motion(own, in_body[20].timestamp_ns);
  ASSERT_TRUE(at && before);
  const Pose& pose = before.value().pose;
  EXPECT_LT(rotation_angle_rad(at.value().pose.R_CT, pose.R_CT * body.R_TB), 1e-9);
  EXPECT_LT((at.value().pose.p_CT - (pose.p_CT + pose.R_CT * body.centroid_T)).norm(), 1e-8);
  for (PoseSample& sample : in_body) {
    sample.pose.R_CT = so3_exp({0.1, 0.0, 0.0}) * sample.pose.R_CT;
  }
  EXPECT_FALSE(model_of_map(in_body, body, view_of(*state_))) << "other axes than the model's";
}

/// A run of so many poses in each T that ends in a mode.
std::vector<MotionState> run_of(std::initializer_list<int> poses_in_each_T, Mode at_end) {
  std::vector<MotionState> published;
  std::uint8_t target_frame = 0;
  for (const int poses : poses_in_each_T) {
    ++target_frame;
    for (int i = 0; i < poses; ++i) {
      published.push_back(
          {.mode = Mode::kTracking, .pose_valid = true, .target_frame = target_frame});
    }
    published.push_back({.mode = at_end, .target_frame = target_frame});
  }
  return published;
}

TEST(IsConfirmed, NotAMapThatWasLostBeforeSixPoses) {
  EXPECT_FALSE(is_confirmed(run_of({5}, Mode::kLost)));
  EXPECT_TRUE(is_confirmed(run_of({6}, Mode::kLost)));
  EXPECT_FALSE(is_confirmed(run_of({40, 5}, Mode::kLost))) << "of the last T";
  EXPECT_TRUE(is_confirmed(run_of({1}, Mode::kTracking))) << "it is held to the end";
  EXPECT_TRUE(is_confirmed({})) << "there is nothing to doubt";
}

}  // namespace
}  // namespace polhode::platform::smoothed_test
