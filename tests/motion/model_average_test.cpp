#include "motion/model_average.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "base/rng.hpp"

namespace polhode::model_average_test {
namespace {

const Eigen::Matrix3d kIdentity = Eigen::Matrix3d::Identity();

Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

/// Observations of one 3-vector.
ModelData repeated(const Eigen::Vector3d& value, double sigma, int count, std::uint64_t seed) {
  Rng rng(seed, 4);
  ModelData data(3);
  for (int i = 0; i < count; ++i) data.add(kIdentity, value + sigma * normal3(&rng), kIdentity);
  return data;
}

/// value = a + b t: six unknowns, a free and b with a prior.
ModelData line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double sigma, int count) {
  Rng rng(9, 4);
  ModelData data(6);
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / count;
    ModelRows rows(3, 6);
    rows << kIdentity, t * kIdentity;
    data.add(rows, a + t * b + sigma * normal3(&rng), kIdentity / (sigma * sigma));
  }
  return data;
}

ModelVector slope_prior(double sigma) {
  ModelVector prior = ModelVector::Zero(6);
  prior.tail<3>().setConstant(1.0 / (sigma * sigma));
  return prior;
}

ModelTarget slope() {
  ModelTarget target = ModelTarget::Zero(6, 3);
  target.bottomRows<3>() = kIdentity;
  return target;
}

TEST(ModelAverage, WithoutAPriorIsTheLeastSquaresAnswer) {
  const ModelData data = repeated({1.0, -2.0, 3.0}, 1.0, 40, 1);
  const std::array<ModelVector, 1> none{ModelVector::Zero(3)};
  const Result<ModelAnswer> answer = average_models(data, none, kIdentity);
  ASSERT_TRUE(answer.ok());
  EXPECT_LT((answer.value().estimate - data.rhs / 40.0).norm(), 1e-12);
  EXPECT_LT((answer.value().unknowns - data.rhs / 40.0).norm(), 1e-12);
  // 1 / 40 where the noise is as declared; the doubt about it adds a little.
  EXPECT_LT(answer.value().misfit, 1.3);
  EXPECT_NEAR(answer.value().covariance.trace() / 3.0, answer.value().misfit / 40.0, 1e-3);
}

TEST(ModelAverage, FindsNoiseThatWasDeclaredTooSmall) {
  const std::array<ModelVector, 1> none{ModelVector::Zero(3)};
  for (const double sigma : {2.0, 6.0, 20.0}) {
    const Result<ModelAnswer> answer =
        average_models(repeated(Eigen::Vector3d::Zero(), sigma, 60, 2), none, kIdentity);
    ASSERT_TRUE(answer.ok());
    // 400 times the declared variance lies beyond the grid of noise factors: chi-square widens.
    EXPECT_GT(answer.value().misfit, 0.6 * sigma * sigma) << sigma;
    EXPECT_LT(answer.value().misfit, 1.8 * sigma * sigma) << sigma;
  }
}

TEST(ModelAverage, NeverTakesTheNoiseForSmallerThanDeclared) {
  const std::array<ModelVector, 1> none{ModelVector::Zero(3)};
  const Result<ModelAnswer> answer =
      average_models(repeated({1.0, 2.0, 3.0}, 0.0, 30, 3), none, kIdentity);
  ASSERT_TRUE(answer.ok());
  EXPECT_NEAR(answer.value().misfit, 1.0, 1e-9);
  EXPECT_NEAR(answer.value().covariance(0, 0), 1.0 / 30.0, 1e-9);
}

TEST(ModelAverage, TakesThePriorThatPredictsTheData) {
  const std::array<ModelVector, 2> priors{slope_prior(1e-3), slope_prior(10.0)};
  const Eigen::Vector3d steep(2.0, -1.0, 0.5);
  const auto bent = average_models(line({1.0, 1.0, 1.0}, steep, 0.01, 50), priors, slope());
  ASSERT_TRUE(bent.ok());
  EXPECT_LT((bent.value().estimate - steep).norm(), 0.05);
  // Without a slope in the data the narrow prior predicts them best, and holds the slope at 0.
  const auto flat =
      average_models(line({1.0, 1.0, 1.0}, Eigen::Vector3d::Zero(), 0.01, 50), priors, slope());
  ASSERT_TRUE(flat.ok());
  EXPECT_LT(flat.value().estimate.norm(), 1e-3);
  EXPECT_LT(flat.value().covariance.trace(), 0.1 * bent.value().covariance.trace());
}

TEST(ModelAverage, IsLinearInWhatIsAsked) {
  const ModelData data = line({1.0, 0.0, -1.0}, {0.3, 0.2, 0.1}, 0.1, 20);
  const std::array<ModelVector, 2> priors{slope_prior(0.1), slope_prior(1.0)};
  const ModelAnswer once = average_models(data, priors, slope()).value();
  const ModelAnswer thrice = average_models(data, priors, 3.0 * slope()).value();
  EXPECT_LT((thrice.estimate - 3.0 * once.estimate).norm(), 1e-12);
  EXPECT_LT((thrice.covariance - 9.0 * once.covariance).norm(), 1e-12);
  EXPECT_EQ(once.covariance, once.covariance.transpose());
}

TEST(ModelAverage, OfASingularSystemIsAnError) {
  const std::array<ModelVector, 1> none{ModelVector::Zero(3)};
  EXPECT_EQ(average_models(ModelData(3), none, kIdentity).error().code, ErrorCode::kDegenerate);
  EXPECT_EQ(average_models(ModelData(3), {}, kIdentity).error().code, ErrorCode::kDegenerate);
  ModelData unusable(3);
  unusable.add(kIdentity,
               Eigen::Vector3d::Ones(),
               Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(average_models(unusable, none, kIdentity).error().code, ErrorCode::kDegenerate);
  // One time for all: value and slope cannot be separated, unless a prior holds the slope.
  ModelData one_time(6);
  ModelRows rows(3, 6);
  rows << kIdentity, kIdentity;
  for (int i = 0; i < 10; ++i) one_time.add(rows, Eigen::Vector3d::Ones(), kIdentity);
  const std::array<ModelVector, 1> none_of_six{ModelVector::Zero(6)};
  EXPECT_FALSE(average_models(one_time, none_of_six, slope()).ok());
  // Nor where the times all but coincide: what separates them is rounding.
  ModelData nearly_one_time(6);
  for (int i = 0; i < 10; ++i) {
    rows.rightCols<3>() = (1.0 + 1e-7 * i) * kIdentity;
    nearly_one_time.add(rows, Eigen::Vector3d::Ones(), kIdentity);
  }
  EXPECT_FALSE(average_models(nearly_one_time, none_of_six, slope()).ok());
  const std::array<ModelVector, 1> held{slope_prior(1.0)};
  EXPECT_TRUE(average_models(one_time, held, slope()).ok());
}

}  // namespace
}  // namespace polhode::model_average_test
