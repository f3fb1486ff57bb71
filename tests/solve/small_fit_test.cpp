#include "solve/small_fit.hpp"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <vector>

#include "base/rng.hpp"
#include "solve/cauchy_loss.hpp"

namespace polhode::small_fit_test {
namespace {

/// Cauchy's loss of a squared residual.
double cauchy_loss(double error2, double width) {
  return width * width * std::log1p(error2 / (width * width));
}

constexpr int kSamples = 40;
constexpr double kSigma = 0.01;
constexpr double kWidth = 2.0;  // of the Cauchy loss, in sigma

// A decay: x0 exp(-x1 t) + x2.
using Decay = SmallEquations<3>;

struct Samples {
  std::array<double, kSamples> time{};
  std::array<double, kSamples> value{};

  [[nodiscard]] double residual(const double* x, std::size_t i) const {
    return (x[0] * std::exp(-x[1] * time[i]) + x[2] - value[i]) / kSigma;
  }
  [[nodiscard]] Eigen::Vector3d derivative(const double* x, std::size_t i) const {
    const double e = std::exp(-x[1] * time[i]);
    return Eigen::Vector3d(e, -x[0] * time[i] * e, 1.0) / kSigma;
  }
};

/// Every tenth sample is an outlier of `outlier_sigmas`.
Samples decay(std::uint64_t seed, double outlier_sigmas) {
  Rng rng(seed, 63);
  Samples s;
  for (std::size_t i = 0; i < kSamples; ++i) {
    s.time[i] = 0.1 * static_cast<double>(i);
    const double error = rng.normal() + (i % 10 == 3 ? outlier_sigmas : 0.0);
    s.value[i] = 2.0 * std::exp(-0.7 * s.time[i]) + 0.5 + kSigma * error;
  }
  return s;
}

/// All residuals, as TinySolver is used without a square root.
struct AllResiduals {
  using Scalar = double;
  // NOLINTNEXTLINE(readability-identifier-naming)
  enum { NUM_RESIDUALS = kSamples, NUM_PARAMETERS = 3 };
  const Samples& samples;

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    for (std::size_t i = 0; i < kSamples; ++i) {
      residuals[i] = samples.residual(x, i);
      for (std::size_t k = 0; jacobian != nullptr && k < 3; ++k) {
        jacobian[k * kSamples + i] = samples.derivative(x, i)(static_cast<Eigen::Index>(k));
      }
    }
    return true;
  }
};

auto linearised(const Samples& s, bool robust) {
  return [&s, robust](const Eigen::Vector3d& x, Decay* at) {
    *at = {};
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double r = s.residual(x.data(), i);
      const Eigen::Vector3d J = s.derivative(x.data(), i);
      const double weight = robust ? cauchy_weight(r * r, kWidth) : 1.0;
      at->H += weight * J * J.transpose();
      at->g += weight * r * J;
      at->cost += robust ? cauchy_loss(r * r, kWidth) : r * r;
    }
    return true;
  };
}

const Eigen::Vector3d kStart(1.0, 0.2, 0.0);

TEST(SmallFit, TakesTheStepsThatTinySolverTakesWithAllResiduals) {
  const Samples s = decay(1, 0.0);
  for (int steps = 1; steps <= 5; ++steps) {
    ceres::TinySolver<AllResiduals> solver;
    solver.options.max_num_iterations = steps + 1;
    Eigen::Vector3d expected = kStart;
    solver.Solve(AllResiduals{s}, &expected);
    Eigen::Vector3d x = kStart;
    Decay at;
    EXPECT_EQ(minimise(linearised(s, false), {.steps_max = steps}, &x, &at), steps);
    // Rounding by the condition of H, about 1e4.
    EXPECT_LT((x - expected).norm(), 1e-11) << steps;
    EXPECT_NEAR(at.cost, 2.0 * solver.summary.final_cost, 1e-10 * at.cost);
  }
}

struct RobustResidual {
  const Samples* samples;
  std::size_t i;

  template <typename T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = (x[0] * exp(-x[1] * samples->time[i]) + x[2] - samples->value[i]) / kSigma;
    return true;
  }
};

TEST(SmallFit, EndsAtTheRobustMinimumThatCeresFinds) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Samples s = decay(seed, 30.0);
    ceres::Problem problem;
    Eigen::Vector3d expected(2.0, 0.7, 0.5);
    for (std::size_t i = 0; i < kSamples; ++i) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RobustResidual, 1, 3>(new RobustResidual{&s, i}),
          new ceres::CauchyLoss(kWidth),
          expected.data());
    }
    ceres::Solver::Options options;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-15;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    Eigen::Vector3d x(1.9, 0.6, 0.6);
    Decay at;
    EXPECT_GT(minimise(linearised(s, true), {.steps_max = 50}, &x, &at), 0);
    // It ends where a step promises 1e-8 of the cost, by weights that overstate the curvature of a
    // concave loss: it may still gain some times that.
    EXPECT_NEAR(at.cost, 2.0 * summary.final_cost, 3e-8 * at.cost);
    const Eigen::Vector3d sigma = at.H.inverse().diagonal().cwiseSqrt();
    EXPECT_LT((x - expected).cwiseQuotient(sigma).norm(), 3e-4 * std::sqrt(at.cost)) << seed;
  }
}

TEST(SmallFit, TurnsToATruthFarFromTheStart) {
  Rng rng(3, 63);
  for (int trial = 0; trial < 20; ++trial) {
    const auto axis = Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
    const Eigen::Matrix3d start = so3_exp({rng.normal(), rng.normal(), rng.normal()});
    const Eigen::Matrix3d truth = so3_exp(1.5 * axis) * start;
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 5; ++i) {
      points.emplace_back(rng.normal(), rng.normal(), rng.normal());
    }
    const auto linearise = [&](const Eigen::Vector3d& phi, SmallEquations<3>* at) {
      *at = {};
      for (const Eigen::Vector3d& p : points) {
        const Eigen::Vector3d turned = so3_exp(phi) * start * p;
        const Eigen::Matrix3d J = -hat(turned);  // by a further rotation
        const Eigen::Vector3d r = turned - truth * p;
        at->H += J.transpose() * J;
        at->g += J.transpose() * r;
        at->cost += r.squaredNorm();
      }
      return true;
    };
    Eigen::Vector3d phi = Eigen::Vector3d::Zero();
    SmallEquations<3> at;
    EXPECT_GT(
        minimise(linearise, {.steps_max = 20, .first_three = FirstThree::kRotation}, &phi, &at), 0);
    // The last step leaves the damping's part, under 1e-4, of a step that gained 1e-8 of the cost.
    EXPECT_LT(rotation_angle_rad(so3_exp(phi) * start, truth), 1e-8) << trial;
  }
}

TEST(SmallFit, StepsBackFromWhereTheModelIsNotDefined) {
  const auto linearise = [](const Eigen::Vector2d& x, SmallEquations<2>* at) {
    if (!(x(0) > 0.0)) {
      return false;
    }
    const double r = std::log(x(0) / 0.1);
    at->H << 1.0 / (x(0) * x(0)), 0.0, 0.0, 1.0;
    at->g << r / x(0), x(1);
    at->cost = r * r + x(1) * x(1);
    return true;
  };
  Eigen::Vector2d x(5.0, 1.0);  // the first undamped step ends at -14.6
  SmallEquations<2> at;
  EXPECT_GT(minimise(linearise, {.steps_max = 100}, &x, &at), 0);
  EXPECT_NEAR(x(0), 0.1, 1e-9);
  x(0) = -1.0;
  EXPECT_EQ(minimise(linearise, {.steps_max = 100}, &x, &at), -1);
  EXPECT_EQ(x(0), -1.0);
}

TEST(SmallFit, LeavesWhatNothingDetermines) {
  const auto linearise = [](const Eigen::Vector2d& x, SmallEquations<2>* at) {
    at->H << 4.0, 0.0, 0.0, 0.0;
    at->g << 4.0 * (x(0) - 3.0), 0.0;
    at->cost = 4.0 * (x(0) - 3.0) * (x(0) - 3.0);
    return true;
  };
  Eigen::Vector2d x(0.0, 7.0);
  SmallEquations<2> at;
  EXPECT_GT(minimise(linearise, {.steps_max = 20}, &x, &at), 0);
  EXPECT_NEAR(x(0), 3.0, 1e-7);  // twice the damping's part of 3
  EXPECT_EQ(x(1), 7.0);
}

TEST(SmallFit, ReportsTheEquationsOfTheBestPlace_WhenTheLastStepFailed) {
  // A wall at 2: three steps towards 10 all end behind it.
  const auto linearise = [](const Eigen::Vector2d& x, SmallEquations<2>* at) {
    at->H.setIdentity();
    at->g << x(0) - 10.0, x(1);
    at->cost = x(0) > 2.0 ? 1000.0 : at->g.squaredNorm();
    return true;
  };
  Eigen::Vector2d x(1.0, 0.0);
  SmallEquations<2> at;
  EXPECT_EQ(minimise(linearise, {.steps_max = 3}, &x, &at), 3);
  EXPECT_EQ(x(0), 1.0);
  EXPECT_EQ(at.cost, 81.0);
}

}  // namespace
}  // namespace polhode::small_fit_test
