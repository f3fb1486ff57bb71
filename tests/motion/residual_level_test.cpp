#include "motion/residual_level.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "base/rng.hpp"

namespace polhode::residual_level_test {
namespace {

using Residuals = std::vector<Eigen::Vector3d>;

/// (1, 1, 1) and its opposite in turn: chi-square 3 each, and neighbours that do not agree.
Residuals alternating(std::size_t count, double size) {
  Residuals residuals;
  for (std::size_t i = 0; i < count; ++i) {
    residuals.push_back(Eigen::Vector3d::Constant(i % 2 == 0 ? size : -size));
  }
  return residuals;
}

/// White noise of which each draw is repeated `repeats` times.
Residuals repeated(std::size_t draws, std::size_t repeats, double sigma, std::uint64_t seed) {
  Rng rng(seed, 1);
  Residuals residuals;
  for (std::size_t i = 0; i < draws; ++i) {
    const Eigen::Vector3d draw = sigma * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
    residuals.insert(residuals.end(), repeats, draw);
  }
  return residuals;
}

TEST(ResidualLevel, OfNoResidualsIsTheDeclaredOne) {
  const ResidualLevel level = residual_level({});
  EXPECT_EQ(level.chi2_per_dof, 0.0);
  EXPECT_EQ(level.scale2, 1.0);
  EXPECT_EQ(level.correlation, 1.0);
  EXPECT_EQ(level.outliers, 0U);
}

TEST(ResidualLevel, CountsUnknownsAndWeighsTheDeclaredSigmaAsTwentyNumbers) {
  const Residuals residuals = alternating(30, 1.0);
  const ResidualLevel level = residual_level({.residuals = residuals, .unknowns = 6});
  EXPECT_NEAR(level.chi2_per_dof, 90.0 / 84.0, 1e-12);
  EXPECT_NEAR(level.scale2, 110.0 / 104.0, 1e-12);
  EXPECT_EQ(level.outliers, 0U);
  EXPECT_EQ(level.correlation, 1.0);
}

TEST(ResidualLevel, KeepsOneDegreeOfFreedom_WhereTheUnknownsAreMore) {
  const Residuals residuals = alternating(2, 1.0);
  const ResidualLevel level = residual_level({.residuals = residuals, .unknowns = 11});
  EXPECT_NEAR(level.chi2_per_dof, 6.0, 1e-12);
  EXPECT_NEAR(level.scale2, 26.0 / 21.0, 1e-12);
}

TEST(ResidualLevel, LeavesOutliersAside_AndWhatIsNotFinite) {
  Residuals residuals = alternating(30, 1.0);
  residuals[7] = {60.0, 0.0, 0.0};
  residuals[20] = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  const ResidualLevel level = residual_level({.residuals = residuals, .unknowns = 0});
  EXPECT_EQ(level.outliers, 2U);
  EXPECT_NEAR(level.chi2_per_dof, 1.0, 1e-12);
  EXPECT_TRUE(std::isfinite(level.correlation));
}

TEST(ResidualLevel, WidensItsGateWithTheNoiseThatItFinds) {
  // 6 sigma as declared, each of them: noise that was declared too small, and no outlier.
  const Residuals residuals = alternating(30, 6.0);
  const ResidualLevel level = residual_level({.residuals = residuals});
  EXPECT_EQ(level.outliers, 0U);
  EXPECT_NEAR(level.chi2_per_dof, 36.0, 1e-12);
}

TEST(ResidualLevel, OfWhiteNoiseIsItsVariance) {
  for (const double sigma : {0.5, 1.0, 3.0}) {
    const ResidualLevel level = residual_level({.residuals = repeated(400, 1, sigma, 2)});
    // 1200 numbers: the variance scatters by sqrt(2 / 1200) = 4 %.
    EXPECT_NEAR(level.chi2_per_dof / (sigma * sigma), 1.0, 0.13) << sigma;
    EXPECT_LT(level.correlation, 1.5) << sigma;
  }
}

TEST(ResidualLevel, CountsPosesThatShareTheirError) {
  // Blocks of 8 equal residuals: 1 + 2 (7 + 6 + ... + 1) / 8 = 8.
  constexpr std::uint64_t kSeeds = 20;
  double mean = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    mean += residual_level({.residuals = repeated(60, 8, 1.0, seed)}).correlation / kSeeds;
  }
  // Only positive pairs are summed, which biases the mean upwards.
  EXPECT_GT(mean, 7.0);
  EXPECT_LT(mean, 10.5);
}

TEST(ResidualLevel, TakesTheMapsDriftForSharedByThePosesOfAnAspect) {
  const Residuals residuals = alternating(100, 1.0);
  const ResidualInput input{.residuals = residuals,
                            .drift_share = 0.5,
                            .rotation_of_frame_rad = 2.0 * kFaceAngle_rad / 16.0};
  EXPECT_NEAR(residual_level(input).correlation, 1.0 + 0.5 * 15.0, 1e-9);
}

TEST(PosesOfASide, AreAtLeastOneAndAtMostHalfOfAll) {
  EXPECT_NEAR(poses_of_a_face(2.0 * kFaceAngle_rad / 16.0, 100), 16.0, 1e-9);
  EXPECT_EQ(poses_of_a_face(0.0, 100), 50.0);  // nothing rotates: one aspect
  EXPECT_EQ(poses_of_a_face(3.0, 100), 1.0);
  EXPECT_EQ(poses_of_a_face(0.0, 1), 1.0);
}

TEST(Widening, IsTheProductOfNoiseAndCorrelation) {
  EXPECT_EQ(widening({.scale2 = 2.0, .correlation = 3.5}), 7.0);
}

}  // namespace
}  // namespace polhode::residual_level_test
