#include "solve/bundle_costs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::bundle_costs_test {
namespace {

// Of images a tenth of a radian wide: residuals of a few sigma are far above rounding.
constexpr double kSigma = 1e-3;
// Of central differences, where their two errors are both about 1e-11 of numbers near 1: the
// square of the step, and rounding over the step.
constexpr double kStep = 1e-5;
// Derivatives are in sigma, 1e3 times those of the images; ten for third derivatives above 1.
constexpr double kDifferenceError = 1e-7;
// Of pose and point together.
constexpr int kUnknowns = kPoseNumbers + 3;

template <int kRows, int kCols>
using RowMajor = Eigen::Matrix<double, kRows, kCols, Eigen::RowMajor>;
using Vector6 = Eigen::Matrix<double, kPoseNumbers, 1>;
using Jacobian6 = RowMajor<kPoseNumbers, kPoseNumbers>;

InverseDepthPose start_pose() {
  return to_inverse_depth({.R_CT = so3_exp({0.4, -0.3, 0.2}), .p_CT = {0.3, -0.2, 10.0}});
}

/// What Ceres may try: numbers of the pose and the point.
struct Trial {
  std::array<double, kPoseNumbers> numbers{};
  Eigen::Vector3d p_T = Eigen::Vector3d(0.6, -0.4, 0.5);

  [[nodiscard]] Trial moved(int k, double step) const {
    Trial trial = *this;
    if (k < kPoseNumbers) {
      trial.numbers[static_cast<std::size_t>(k)] += step;
    } else {
      trial.p_T(k - kPoseNumbers) += step;
    }
    return trial;
  }
};

/// The start, a small step, and turns up to far more than an adjustment makes.
std::vector<Trial> trials() {
  std::vector<Trial> all;
  for (const Eigen::Vector3d& phi : {Eigen::Vector3d(0.0, 0.0, 0.0),
                                     Eigen::Vector3d(1e-4, -2e-4, 1e-4),
                                     Eigen::Vector3d(0.3, -0.2, 0.5),
                                     Eigen::Vector3d(-1.1, 0.4, 0.9)}) {
    Trial trial;
    trial.numbers = {phi.x(), phi.y(), phi.z()};
    Eigen::Map<Eigen::Vector3d>{&trial.numbers[3]} = start_pose().uvs + 0.02 * phi;
    all.push_back(trial);
  }
  return all;
}

/// The second of two poses of Ceres's, for costs to refer to.
struct Chart {
  ChartedPoses poses{std::vector<InverseDepthPose>(2, start_pose())};

  [[nodiscard]] const ChartedPose& pose() const { return poses[1]; }
  void go_to(const Trial& trial, bool with_derivatives) {
    std::copy(trial.numbers.begin(), trial.numbers.end(), poses.numbers(1));
    poses.PrepareForEvaluation(with_derivatives, true);
  }
};

/// A reprojection cost by itself.
struct Reprojection {
  Chart chart;
  ReprojectionCost cost;
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();
  RowMajor<2, kPoseNumbers> by_pose = RowMajor<2, kPoseNumbers>::Zero();
  RowMajor<2, 3> by_point = RowMajor<2, 3>::Zero();

  explicit Reprojection(const BundleObservation& o) : cost(o, chart.pose()) {}

  bool evaluate(const Trial& trial) {
    chart.go_to(trial, true);
    std::array<double*, 2> jacobians{by_pose.data(), by_point.data()};
    return at(trial, jacobians.data());
  }
  Eigen::Vector2d value(const Trial& trial) {
    chart.go_to(trial, false);
    EXPECT_TRUE(at(trial, nullptr));
    return residual;
  }
  bool at(const Trial& trial, double** jacobians) {
    const std::array<const double*, 2> parameters{trial.numbers.data(), trial.p_T.data()};
    return cost.Evaluate(parameters.data(), residual.data(), jacobians);
  }
  [[nodiscard]] Eigen::Matrix<double, 2, kUnknowns> by_all() const {
    Eigen::Matrix<double, 2, kUnknowns> J;
    J << by_pose, by_point;
    return J;
  }
};

/// An observation that lies `off` sigma before the image of the trial's point.
BundleObservation observation(const Trial& trial, const Eigen::Vector2d& off) {
  Chart chart;
  chart.go_to(trial, false);
  BundleObservation o{.pose = 1, .sigma_normalised = kSigma};
  EXPECT_TRUE(reproject(chart.pose().pose, trial.p_T, &o.normalised));
  o.normalised -= kSigma * off;
  return o;
}

// Sigma: residuals as noise leaves them, and one far beyond.
const std::array<Eigen::Vector2d, 3> kOff{
    Eigen::Vector2d(0.3, -0.1), Eigen::Vector2d(-1.5, 1.6), Eigen::Vector2d(20.0, 9.0)};

TEST(ChartedPoses, AreTheStart_AtItsNumbers) {
  const std::vector<InverseDepthPose> start{start_pose(), {.R_CT = so3_exp({1.0, 0.0, 0.0})}};
  ChartedPoses poses(start);
  for (const bool prepared : {false, true}) {
    if (prepared) poses.PrepareForEvaluation(true, true);
    for (std::size_t k = 0; k < start.size(); ++k) {
      EXPECT_EQ(poses[k].pose.R_CT, start[k].R_CT) << k;
      EXPECT_EQ(poses[k].pose.uvs, start[k].uvs) << k;
      EXPECT_EQ(Eigen::Map<const Eigen::Vector3d>(poses.numbers(k)), Eigen::Vector3d::Zero());
      EXPECT_EQ(Eigen::Map<const Eigen::Vector3d>(poses.numbers(k) + 3), start[k].uvs);
      EXPECT_EQ(poses[k].turn_by_phi, Eigen::Matrix3d::Identity()) << k;
    }
  }
}

TEST(ChartedPoses, TurnTheStartFromTheLeft_EachByItsOwnNumbers) {
  for (const Trial& trial : trials()) {
    Chart chart;
    chart.go_to(trial, true);
    const Eigen::Map<const Eigen::Vector3d> phi(trial.numbers.data());
    EXPECT_EQ(chart.pose().pose.R_CT, so3_exp(phi) * start_pose().R_CT);
    EXPECT_EQ(chart.pose().pose.uvs, Eigen::Map<const Eigen::Vector3d>(&trial.numbers[3]));
    EXPECT_EQ(chart.pose().turn_by_phi, so3_left_jacobian(phi));
    EXPECT_EQ(chart.poses[0].pose.R_CT, start_pose().R_CT);
    // From the start again: turns do not add up.
    chart.go_to({.numbers = {0.0, 0.0, 0.0, 0.1, 0.2, 0.3}}, true);
    EXPECT_EQ(chart.pose().pose.R_CT, start_pose().R_CT);
    EXPECT_EQ(chart.pose().turn_by_phi, Eigen::Matrix3d::Identity());
  }
}

TEST(ReprojectionCost, ResidualIsTheDistanceInSigma) {
  for (const Trial& trial : trials()) {
    for (const Eigen::Vector2d& off : kOff) {
      for (const double sigmas : {1.0, 0.5}) {
        BundleObservation o = observation(trial, off);
        o.sigma_normalised *= sigmas;
        Reprojection r(o);
        ASSERT_TRUE(r.evaluate(trial));
        // Rounding of the image over sigma is 1e-13; a hundred of it.
        EXPECT_LT((r.residual - off / sigmas).norm(), 1e-11) << off.norm();
        EXPECT_EQ(r.value(trial), r.residual);
      }
    }
  }
}

TEST(ReprojectionCost, DerivativeIsTheResiduals) {
  for (const Trial& trial : trials()) {
    for (const Eigen::Vector2d& off : kOff) {
      Reprojection r(observation(trial, off));
      ASSERT_TRUE(r.evaluate(trial));
      const Eigen::Matrix<double, 2, kUnknowns> J = r.by_all();
      for (int k = 0; k < kUnknowns; ++k) {
        const Eigen::Vector2d slope =
            0.5 / kStep * (r.value(trial.moved(k, kStep)) - r.value(trial.moved(k, -kStep)));
        EXPECT_LT((J.col(k) - slope).norm(), kDifferenceError * (1.0 + J.norm())) << k;
      }
    }
  }
}

TEST(ReprojectionCost, HasNoValueBehindTheCameraOrBeyondInfiniteDepth) {
  const Trial good = trials()[2];
  Reprojection r(observation(good, {1.0, 1.0}));
  EXPECT_TRUE(r.evaluate(good));
  Trial behind = good;
  behind.p_T = -20.0 * r.chart.pose().pose.R_CT.row(2).transpose();  // ten in front of T
  EXPECT_FALSE(r.evaluate(behind));
  EXPECT_FALSE(r.at(behind, nullptr));
  for (const double s : {0.0, -0.1}) {
    Trial beyond = good;
    beyond.numbers[5] = s;
    EXPECT_FALSE(r.evaluate(beyond)) << s;
  }
}

TEST(ReprojectionCost, GivesTheJacobiansItIsAskedFor) {
  const Trial trial = trials()[3];
  Reprojection all(observation(trial, {1.0, 1.0}));
  ASSERT_TRUE(all.evaluate(trial));
  Reprojection some(observation(trial, {1.0, 1.0}));
  some.chart.go_to(trial, true);
  std::array<double*, 2> of_pose{some.by_pose.data(), nullptr};
  ASSERT_TRUE(some.at(trial, of_pose.data()));
  EXPECT_EQ(some.by_pose, all.by_pose);
  EXPECT_TRUE(some.by_point.isZero(0.0));
  some.by_pose.setZero();
  std::array<double*, 2> of_point{nullptr, some.by_point.data()};
  ASSERT_TRUE(some.at(trial, of_point.data()));
  EXPECT_EQ(some.by_point, all.by_point);
  EXPECT_TRUE(some.by_pose.isZero(0.0));
  EXPECT_EQ(some.value(trial), all.residual);
}

/// A pose prior's cost by itself. Its mean is off the start in all numbers, its information is
/// that of six unequal, correlated directions.
struct Prior {
  Chart chart;
  PosePrior prior{.pose = 1, .mean = start_pose()};
  Vector6 residual = Vector6::Zero();
  Jacobian6 J = Jacobian6::Zero();

  Prior() {
    Rng rng(2, 7);
    Jacobian6 root;
    for (double& element : root.reshaped()) element = rng.normal();
    prior.information = root.transpose() * root;
    prior.mean.R_CT = so3_exp({0.2, 0.1, -0.3}) * prior.mean.R_CT;
    prior.mean.uvs += Eigen::Vector3d(0.02, -0.01, 0.03);
  }

  Vector6 value(const Trial& trial, double** jacobians = nullptr) {
    chart.go_to(trial, true);
    const std::array<const double*, 1> parameters{trial.numbers.data()};
    const PosePriorCost cost(prior, chart.pose());
    EXPECT_TRUE(cost.Evaluate(parameters.data(), residual.data(), jacobians));
    return residual;
  }
  void evaluate(const Trial& trial) {
    std::array<double*, 1> jacobians{J.data()};
    (void)value(trial, jacobians.data());
  }
};

TEST(PosePriorCost, SquareIsTheDepartureInSigma) {
  Prior p;
  for (const Trial& trial : trials()) {
    p.evaluate(trial);
    const InverseDepthPose& pose = p.chart.pose().pose;
    Vector6 deviation;
    deviation << so3_log(pose.R_CT * p.prior.mean.R_CT.transpose()), pose.uvs - p.prior.mean.uvs;
    const double expected = deviation.dot(p.prior.information * deviation);
    // Rounding of an eigenvalue's root.
    EXPECT_NEAR(p.residual.squaredNorm(), expected, 1e-12 * (1.0 + expected));
    EXPECT_GT(expected, 0.01);
  }
}

TEST(PosePriorCost, DerivativeIsTheResiduals) {
  Prior p;
  for (const Trial& trial : trials()) {
    p.evaluate(trial);
    for (int k = 0; k < kPoseNumbers; ++k) {
      const Vector6 slope =
          0.5 / kStep * (p.value(trial.moved(k, kStep)) - p.value(trial.moved(k, -kStep)));
      EXPECT_LT((p.J.col(k) - slope).norm(), kDifferenceError * p.J.norm()) << k;
    }
  }
}

TEST(PosePriorCost, CostsNothingWhereItHasNoInformation) {
  Prior p;
  p.prior.information.setZero();
  p.prior.information(4, 4) = 9.0;
  p.prior.information(2, 2) = -1e-15;  // rounding can leave it below zero
  p.evaluate(trials()[2]);
  const double off = p.chart.pose().pose.uvs.y() - p.prior.mean.uvs.y();
  EXPECT_NEAR(p.residual.squaredNorm(), 9.0 * off * off, 1e-12);
  EXPECT_TRUE(p.J.allFinite());
  EXPECT_NEAR(p.J.squaredNorm(), 9.0, 1e-12);
}

TEST(PosePriorCost, NeedsNoJacobian) {
  Prior p;
  p.evaluate(trials()[2]);
  const Vector6 with = p.residual;
  EXPECT_EQ(p.value(trials()[2]), with);
  std::array<double*, 1> none{nullptr};
  EXPECT_EQ(p.value(trials()[2], none.data()), with);
}

/// A link over four poses that turn by some tenths of a radian, each seen by a camera that turns.
struct Linked {
  static constexpr std::size_t kPoses = RateLink::kPoses;
  std::vector<Eigen::Matrix3d> R_IC;
  ChartedPoses poses;
  RateLink link;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  std::array<RowMajor<3, kPoseNumbers>, kPoses> J;

  /// @param part  of all turns of the body
  explicit Linked(double part = 1.0) : poses(start_poses(part)) {
    link.factors_1_rad = {5.0, -12.0, 7.0};
    link.turn_rad = 0.5;
    for (std::size_t k = 0; k < kPoses; ++k) {
      R_IC.push_back(camera_attitude(k));
      (void)link.poses.push_back(static_cast<std::int32_t>(k));
    }
  }

  static Eigen::Matrix3d camera_attitude(std::size_t k) {
    return so3_exp(0.3 * static_cast<double>(k) * Eigen::Vector3d(0.5, 1.0, -0.4));
  }
  static std::vector<InverseDepthPose> start_poses(double part) {
    std::vector<InverseDepthPose> all;
    for (const double angle_rad : {0.0, 0.16, 0.30, 0.55}) {
      const Eigen::Matrix3d R_IT =
          so3_exp(part * angle_rad * Eigen::Vector3d(0.6, -0.8, 0.0)) * so3_exp({0.4, -0.3, 0.2});
      all.push_back({.R_CT = camera_attitude(all.size()).transpose() * R_IT,
                     .uvs = Eigen::Vector3d(0.03, -0.02, 0.1)});
    }
    return all;
  }

  Eigen::Vector3d value(double** jacobians = nullptr) {
    poses.PrepareForEvaluation(true, true);
    const RateLinkCost cost(link, R_IC, poses);
    EXPECT_TRUE(cost.Evaluate(nullptr, residual.data(), jacobians));
    return residual;
  }
};

TEST(RateLinkCost, IsTheChangeOfTheRate_InProportionToTheWholeTurn) {
  Linked all;
  // 5 x 0.16 - 12 x 0.14 + 7 x 0.25 about the axis, by 0.5 over the whole turn.
  const double least_rad = RateLink::kTurnLeast_rad;
  const double in_proportion = 0.5 / std::hypot(0.55, least_rad);
  const Eigen::Vector3d expected = 0.87 * in_proportion * Eigen::Vector3d(0.6, -0.8, 0.0);
  EXPECT_LT((all.value() - expected).norm(), 1e-9);
  Linked half(0.5);
  const double half_in_proportion = 0.5 / std::hypot(0.275, least_rad);
  EXPECT_LT((half.value() - 0.5 * half_in_proportion / in_proportion * expected).norm(), 1e-9);
  EXPECT_LT((half.value() - all.value()).norm(), 1e-3);
}

TEST(RateLinkCost, DerivativeIsTheResiduals) {
  for (const Eigen::Vector3d& phi :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.05, -0.1, 0.08)}) {
    Linked l;
    for (std::size_t k = 0; k < Linked::kPoses; ++k) {
      Eigen::Map<Eigen::Vector3d>{l.poses.numbers(k)} = static_cast<double>(k) * phi;
    }
    std::array<double*, Linked::kPoses> jacobians;
    for (std::size_t k = 0; k < Linked::kPoses; ++k) {
      jacobians[k] = l.J[k].data();
    }
    (void)l.value(jacobians.data());
    for (std::size_t k = 0; k < Linked::kPoses; ++k) {
      for (int n = 0; n < kPoseNumbers; ++n) {
        double* const number = &l.poses.numbers(k)[n];
        const double at = *number;
        *number = at + kStep;
        const Eigen::Vector3d above = l.value();
        *number = at - kStep;
        const Eigen::Vector3d slope = 0.5 / kStep * (above - l.value());
        *number = at;
        EXPECT_LT((l.J[k].col(n) - slope).norm(), kDifferenceError * (1.0 + l.J[k].norm()))
            << k << ", " << n;
      }
    }
  }
}

TEST(RateLinkCost, GivesTheJacobiansItIsAskedFor) {
  Linked l;
  l.J[2].setZero();
  std::array<double*, Linked::kPoses> jacobians{nullptr, nullptr, l.J[2].data(), nullptr};
  (void)l.value(jacobians.data());
  EXPECT_GT(l.J[2].norm(), 1.0);
}

}  // namespace
}  // namespace polhode::bundle_costs_test
