#include "motion/rates.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "free_body.hpp"

namespace polhode::rates_test {
namespace {

double chi2(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

// 95 % point of chi-square with three degrees of freedom.
constexpr double kChi2_95 = 7.815;

struct Case {
  const char* name;
  FreeBody body;
  double interval_s;
};

std::vector<Case> cases() {
  FreeBody spin;
  spin.w_T_rad_s = {0.0, 0.0, 10.0 * kDegree_rad};
  FreeBody rest;
  return {{"paper, 10 s and 10 deg a frame", paper_body(), 10.0},
          {"asymmetric, 10 deg a frame", asymmetric_body(10.0 * kDegree_rad), 1.0},
          {"asymmetric, 30 deg a frame", asymmetric_body(30.0 * kDegree_rad), 1.0},
          {"asymmetric, 0.07 deg a frame", asymmetric_body(2.0 * kDegree_rad), 1.0 / 30.0},
          {"asymmetric, 0.3 deg a frame", asymmetric_body(10.0 * kDegree_rad), 1.0 / 30.0},
          {"pure spin", spin, 1.0},
          {"at rest", rest, 1.0 / 30.0}};
}

struct Tally {
  int count = 0;
  int inside = 0;
  double error2 = 0.0;
  double sigma2 = 0.0;

  void add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
    ++count;
    inside += chi2(error, covariance) < kChi2_95 ? 1 : 0;
    error2 += error.squaredNorm();
    sigma2 += covariance.trace();
  }
  [[nodiscard]] double part_inside() const { return static_cast<double>(inside) / count; }
  [[nodiscard]] double rms() const { return std::sqrt(error2 / count); }
  [[nodiscard]] double sigma() const { return std::sqrt(sigma2 / count); }
};

struct Tallies {
  Tally rate, velocity, attitude_ahead, position_ahead;
};

/// Causal estimates at every eighth frame (neighbours share most of their window) of several runs.
Tallies run_causal(const Case& one,
                   std::size_t first_frame,
                   std::size_t last_frame,
                   std::size_t step) {
  Tallies tallies;
  const std::vector<TruthSample> truth = tumble(one.body, last_frame + 2, one.interval_s);
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const std::vector<PoseSample> poses = observed(truth, {}, seed);
    const std::span<const PoseSample> all(poses);
    for (std::size_t i = first_frame; i <= last_frame; i += step) {
      const Result<RateEstimate> rates = estimate_rates(all.first(i + 1), {});
      EXPECT_TRUE(rates.ok());
      tallies.rate.add(rates.value().w_T_rad_s - truth[i].w_T_rad_s, rates.value().covariance_w_T);
      tallies.velocity.add(rates.value().v_C - truth[i].v_C, rates.value().covariance_v_C);
      const Result<PosePrediction> ahead =
          predict_pose(all.first(i + 1), truth[i + 1].timestamp_ns, {});
      EXPECT_TRUE(ahead.ok());
      tallies.attitude_ahead.add(
          so3_log(truth[i + 1].pose.R_CT * ahead.value().pose.R_CT.transpose()),
          ahead.value().covariance.topLeftCorner<3, 3>());
      tallies.position_ahead.add(truth[i + 1].pose.p_CT - ahead.value().pose.p_CT,
                                 ahead.value().covariance.bottomRightCorner<3, 3>());
    }
  }
  return tallies;
}

TEST(Rates, AreConsistentWithTheirSigmasAndNotTooWide) {
  for (const Case& one : cases()) {
    const Tallies t = run_causal(one, 8, 200, 8);
    // 150 values, of which neighbours share data: 95 % less three standard deviations of 40
    // independent ones, 0.85.
    for (const auto& [what, tally] : {std::pair{"rate", &t.rate},
                                      {"velocity", &t.velocity},
                                      {"attitude ahead", &t.attitude_ahead},
                                      {"position ahead", &t.position_ahead}}) {
      EXPECT_GT(tally->part_inside(), 0.85) << one.name << ", " << what;
      EXPECT_LT(tally->sigma(), 3.0 * tally->rms()) << one.name << ", " << what;
    }
  }
}

TEST(Rates, AreConsistentWithVeryFewPoses) {
  for (const Case& one : cases()) {
    for (std::size_t frames = 2; frames <= 5; ++frames) {
      Tally tally;
      const std::vector<TruthSample> truth = tumble(one.body, frames, one.interval_s);
      for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const Result<RateEstimate> rates = estimate_rates(observed(truth, {}, seed), {});
        ASSERT_TRUE(rates.ok());
        tally.add(rates.value().w_T_rad_s - truth.back().w_T_rad_s, rates.value().covariance_w_T);
      }
      // 60 independent values; three standard deviations under 0.95 is 0.87.
      EXPECT_GT(tally.part_inside(), 0.85) << one.name << ", " << frames << " poses";
    }
  }
}

TEST(Rates, OfThePapersCaseAreBetterThanDifferencesOfPoses) {
  const Case paper = cases()[0];
  const Tallies t = run_causal(paper, 30, 200, 10);
  // A difference of two poses has 1e-3 sqrt(2) sqrt(2) / 10 s in its two weak axes: 0.0115 deg/s,
  // plus half an interval of the wobble's change, 0.1 deg/s 0.167 / 2 = 0.008 deg/s.
  EXPECT_LT(t.rate.rms(), 0.0085 * kDegree_rad);
}

TEST(Rates, FromBothSidesReachTheCentreOfTheNoise) {
  const std::vector<TruthSample> truth = tumble(paper_body(), 120, 10.0);
  Tally tally;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const std::vector<PoseSample> poses = observed(truth, {}, seed);
    for (std::size_t i = 20; i < 100; i += 5) {
      const Result<RateEstimate> rates = estimate_rates_at(poses, i, {});
      ASSERT_TRUE(rates.ok());
      tally.add(rates.value().w_T_rad_s - truth[i].w_T_rad_s, rates.value().covariance_w_T);
    }
  }
  EXPECT_GT(tally.part_inside(), 0.85);
  EXPECT_LT(tally.rms(), 0.002 * kDegree_rad);
}

TEST(Rates, AreExactForAConstantRateWithoutNoise) {
  FreeBody body;
  body.w_T_rad_s = {0.02, -0.11, 0.05};
  body.R_CT = so3_exp({1.0, 0.4, -0.3});
  body.v_mass_centre_C = {0.01, 0.02, -0.03};
  const std::vector<TruthSample> truth = tumble(body, 8, 1.0);
  std::vector<PoseSample> poses =
      observed(truth, {.attitude_rad = {1e-9, 1e-9, 1e-9}, .position = {1e-9, 1e-9, 1e-9}}, 1);
  const Result<RateEstimate> rates = estimate_rates(poses, {});
  ASSERT_TRUE(rates.ok());
  EXPECT_LT((rates.value().w_T_rad_s - body.w_T_rad_s).norm(), 1e-7);
  EXPECT_LT((rates.value().v_C - body.v_mass_centre_C).norm(), 1e-7);
  EXPECT_LT(rotation_angle_rad(rates.value().pose.R_CT, truth.back().pose.R_CT), 1e-7);
}

TEST(Rates, WidenWhenTheDeclaredNoiseIsTooSmall) {
  const std::vector<TruthSample> truth = tumble(asymmetric_body(5.0 * kDegree_rad), 60, 0.5);
  Tally tally;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    std::vector<PoseSample> poses = observed(truth, {}, seed);
    for (PoseSample& pose : poses) pose.covariance /= 9.0;
    const Result<RateEstimate> rates = estimate_rates(poses, {});
    ASSERT_TRUE(rates.ok());
    EXPECT_GT(rates.value().rotation_misfit, 2.0);
    tally.add(rates.value().w_T_rad_s - truth.back().w_T_rad_s, rates.value().covariance_w_T);
  }
  EXPECT_GT(tally.part_inside(), 0.8);
}

/// A table that is turned by hand: it stops and goes on, 16 s from one stop to the next.
std::vector<TruthSample> turned_by_hand() {
  constexpr double kMean_rad_s = 4.0 * kDegree_rad;
  constexpr double kCycle_rad_s = 2.0 * std::numbers::pi / 16.0;
  std::vector<TruthSample> truth;
  for (int i = 0; i < 100; ++i) {
    const double t_s = 0.5 * i;
    const double angle_rad = kMean_rad_s * (t_s - std::sin(kCycle_rad_s * t_s) / kCycle_rad_s);
    truth.push_back(
        {.timestamp_ns = 500'000'000LL * i,
         .pose = {.R_CT = so3_exp({0.4, 0.0, 0.0}) * so3_exp({0.0, angle_rad, 0.0}),
                  .p_CT = {0.0, 0.0, 8.0}},
         .w_T_rad_s = Eigen::Vector3d(0.0, kMean_rad_s * (1.0 - std::cos(kCycle_rad_s * t_s)), 0.0),
         .v_C = Eigen::Vector3d::Zero()});
  }
  return truth;
}

TEST(Rates, FollowABodyThatIsNotFree_AndSayHowWell) {
  const std::vector<TruthSample> truth = turned_by_hand();
  const std::vector<PoseSample> poses =
      observed(truth, {.attitude_rad = {5e-4, 5e-4, 5e-4}, .position = {1e-3, 1e-3, 1e-2}}, 7);
  for (const bool both_sides : {false, true}) {
    Tally tally;
    for (std::size_t i = 20; i + 1 < poses.size(); ++i) {
      const auto seen = std::span(poses).first(both_sides ? poses.size() : i + 1);
      const Result<RateEstimate> rates = estimate_rates_at(seen, i, {});
      ASSERT_TRUE(rates.ok());
      tally.add(rates.value().w_T_rad_s - truth[i].w_T_rad_s, rates.value().covariance_w_T);
    }
    EXPECT_GT(tally.part_inside(), 0.93) << both_sides;
    // A twentieth of the mean rate; a window of a free body's length is off by all of it.
    EXPECT_LT(tally.rms(), 0.2 * kDegree_rad) << both_sides;
    EXPECT_LT(tally.sigma(), 0.4 * kDegree_rad) << both_sides;
  }
}

TEST(Rates, NeedTwoPosesAndUsableCovariances) {
  const std::vector<TruthSample> truth = tumble(paper_body(), 5, 10.0);
  std::vector<PoseSample> poses = observed(truth, {}, 1);
  EXPECT_EQ(estimate_rates({}, {}).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(estimate_rates(std::span(poses).first(1), {}).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_EQ(predict_pose(std::span(poses).first(1), poses[1].timestamp_ns, {}).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_EQ(predict_pose(poses, poses[0].timestamp_ns, {}).error().code, ErrorCode::kDegenerate);
  poses[3].covariance.setZero();
  EXPECT_EQ(estimate_rates(poses, {}).error().code, ErrorCode::kDegenerate);
  poses[3].covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(estimate_rates(poses, {}).error().code, ErrorCode::kDegenerate);
}

TEST(Prediction, GrowsLessSureWithTime) {
  const std::vector<PoseSample> poses = observed(tumble(paper_body(), 40, 10.0), {}, 2);
  double previous = 0.0;
  for (const double ahead_s : {0.0, 10.0, 30.0, 60.0, 120.0}) {
    const auto when = poses.back().timestamp_ns + std::llround(1e9 * ahead_s);
    const Result<PosePrediction> prediction = predict_pose(poses, when, {});
    ASSERT_TRUE(prediction.ok());
    const double sigma = worst_sigma(prediction.value().covariance.topLeftCorner<3, 3>());
    EXPECT_GT(sigma, previous);
    previous = sigma;
  }
}

TEST(Prediction, FollowsAnAcceleratingSpin) {
  // Spun up by 0.02 rad/s^2, 10 deg a frame in the end: not a free body, still followed.
  std::vector<TruthSample> truth;
  for (int i = 0; i < 12; ++i) {
    const double t = i;
    const double angle = 0.05 * t + 0.01 * t * t;
    truth.push_back({.timestamp_ns = std::llround(1e9 * t),
                     .pose = {.R_CT = so3_exp({0.0, angle, 0.0}), .p_CT = {0.0, 0.0, 5.0}},
                     .w_T_rad_s = {0.0, 0.05 + 0.02 * t, 0.0},
                     .v_C = Eigen::Vector3d::Zero()});
  }
  const std::vector<PoseSample> poses = observed(truth, {}, 3);
  const Result<PosePrediction> prediction =
      predict_pose(std::span(poses).first(11), poses[11].timestamp_ns, {});
  ASSERT_TRUE(prediction.ok());
  const Eigen::Vector3d error =
      so3_log(truth[11].pose.R_CT * prediction.value().pose.R_CT.transpose());
  EXPECT_LT(error.norm(), 0.5 * kDegree_rad);
  EXPECT_LT(chi2(error, prediction.value().covariance.topLeftCorner<3, 3>()), 16.3);  // 99.9 %
}

TEST(Prediction, IsTheSameWhereverTheTimeStampsStart) {
  std::vector<PoseSample> poses = observed(tumble(asymmetric_body(0.1), 20, 1.0), {}, 4);
  const Result<PosePrediction> late =
      predict_pose(poses, poses.back().timestamp_ns + 1'000'000'000, {});
  for (PoseSample& pose : poses) pose.timestamp_ns -= 1'700'000'000'000'000'000;
  const Result<PosePrediction> early =
      predict_pose(poses, poses.back().timestamp_ns + 1'000'000'000, {});
  ASSERT_TRUE(late.ok() && early.ok());
  EXPECT_EQ(late.value().pose.R_CT, early.value().pose.R_CT);
  EXPECT_EQ(late.value().covariance, early.value().covariance);
}

TEST(History, DropsTheOldestWhenFullAndRefusesTimeThatDoesNotIncrease) {
  const auto history = std::make_unique<PoseHistory>();
  for (std::size_t i = 0; i < PoseHistory::capacity() + 10; ++i) {
    ASSERT_TRUE(remember(*history, {.timestamp_ns = static_cast<std::int64_t>(i), .pose = {}}));
  }
  EXPECT_EQ(history->size(), PoseHistory::capacity());
  EXPECT_EQ((*history)[0].timestamp_ns, 10);
  const std::int64_t last = history->back().timestamp_ns;
  EXPECT_FALSE(remember(*history, {.timestamp_ns = last, .pose = {}}));
  EXPECT_FALSE(remember(*history, {.timestamp_ns = last - 1, .pose = {}}));
  EXPECT_EQ(history->back().timestamp_ns, last);
}

TEST(Publish, FillsRatesAndFlags) {
  RateEstimate rates;
  rates.w_T_rad_s = {1.0, 2.0, 3.0};
  rates.v_C = {4.0, 5.0, 6.0};
  rates.covariance_w_T = Eigen::Vector3d(1.0, 9.0, 4.0).asDiagonal();
  rates.covariance_v_C = Eigen::Vector3d(0.25, 0.01, 0.04).asDiagonal();
  MotionState state;
  publish(rates, state);
  EXPECT_TRUE(state.rate_valid && state.velocity_valid);
  EXPECT_EQ(state.w_T_rad_s, (std::array<double, 3>{1.0, 2.0, 3.0}));
  EXPECT_EQ(state.v_C, (std::array<double, 3>{4.0, 5.0, 6.0}));
  EXPECT_NEAR(state.sigma_rate_rad_s, 3.0, 1e-12);
  EXPECT_NEAR(state.sigma_vel, 0.5, 1e-12);
}

TEST(Rates, AreNotToldAcrossAGap_InWhichABodyMayHaveTurnedByAnyNumberOfTurns) {
  const std::vector<TruthSample> truth = tumble(asymmetric_body(5.0 * kDegree_rad), 12, 1.0);
  std::vector<PoseSample> poses = observed(truth, {}, 1);
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  poses.back().timestamp_ns += kDay_ns;
  EXPECT_FALSE(estimate_rates(poses, {}).ok()) << "the last pose stands alone";
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const Result<RateEstimate> rates = estimate_rates_at(poses, i, {});
    ASSERT_TRUE(rates.ok());
    EXPECT_LT(chi2(rates.value().w_T_rad_s - truth[i].w_T_rad_s, rates.value().covariance_w_T),
              25.0)
        << i;
  }
}

TEST(Rates, OfLostFramesAreToldWhileTheTurnIsPlain) {
  const std::vector<TruthSample> truth = tumble(asymmetric_body(5.0 * kDegree_rad), 40, 1.0);
  std::vector<PoseSample> poses = observed(truth, {}, 1);
  poses.erase(poses.begin() + 20, poses.begin() + 38);  // 90 deg
  const Result<RateEstimate> rates = estimate_rates(poses, {});
  ASSERT_TRUE(rates.ok());
  EXPECT_LT((rates.value().w_T_rad_s - truth.back().w_T_rad_s).norm(), 1.0 * kDegree_rad);
}

}  // namespace
}  // namespace polhode::rates_test
