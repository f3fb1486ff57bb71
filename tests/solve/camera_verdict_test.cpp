#include "solve/camera_verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace polhode::camera_verdict_test {
namespace {

/// A fit whose deviations have independent errors; the cost falls as its quadratic form says.
CameraFit fit_of(const Deviations& value, const Deviations& sigma) {
  const Deviations weight = sigma.cwiseAbs2().cwiseInverse();
  return {.usable = true,
          .value = value,
          .information = DeviationInformation(weight.asDiagonal()),
          .gain = value.dot(weight.cwiseProduct(value))};
}

CameraFit fit_of(Deviation deviation, double value, double sigma) {
  Deviations values = Deviations::Zero();
  values[static_cast<Eigen::Index>(deviation)] = value;
  return fit_of(values, Deviations::Constant(sigma));
}

bool contradicts(Deviation deviation, double value, double sigma) {
  return find_deviations(fit_of(deviation, value, sigma)).is(deviation);
}

// verifies: MAP-11
TEST(CameraVerdict, ContradictsBeyondFourSigma) {
  for (const Deviation one : {Deviation::kAspect, Deviation::kReadout, Deviation::kHalf}) {
    EXPECT_TRUE(contradicts(one, 0.0041, 0.001));
    EXPECT_TRUE(contradicts(one, -0.0041, 0.001));
    EXPECT_FALSE(contradicts(one, 0.0039, 0.001));
  }
}

TEST(CameraVerdict, AFocalLengthCountsFromEightPerCentOn) {
  for (const Deviation one : {Deviation::kFocal, Deviation::kZoom}) {
    EXPECT_FALSE(contradicts(one, 0.079, 0.001));
    EXPECT_TRUE(contradicts(one, 0.081, 0.001));
    EXPECT_FALSE(contradicts(one, 0.081, 0.021)) << "four sigma are more than that";
  }
}

TEST(CameraVerdict, APrincipalPointIsOneStatementOfTwoNumbers) {
  Deviations value = Deviations::Zero();
  value[3] = 0.0032;
  value[4] = 0.0032;
  const CameraFinding found =
      find_deviations(fit_of(value, Deviations::Constant(0.001)));  // 4.5 sigma together
  EXPECT_TRUE(found.is(Deviation::kPrincipalU) && found.is(Deviation::kPrincipalV));
  EXPECT_FALSE(contradicts(Deviation::kPrincipalU, 0.0043, 0.001)) << "of two freedoms";
}

TEST(CameraVerdict, WhatTheCostDidNotFallByIsNotExplained) {
  CameraFit fit = fit_of(Deviation::kAspect, 0.1, 0.001);
  fit.gain = 15.0;
  EXPECT_FALSE(find_deviations(fit).any());
  EXPECT_FALSE(find_deviations({}).any());
}

TEST(CameraVerdict, OneDeviationDoesNotContradictWhatIsAlike) {
  // Zoom and focal length are nearly one: only their sum is known well.
  CameraFit fit = fit_of(Deviations::Zero(), Deviations::Constant(0.5));
  fit.information(0, 0) = fit.information(1, 1) = 1e4;
  fit.information(0, 1) = fit.information(1, 0) = 0.98e4;
  fit.value[0] = 0.2;
  fit.gain = fit.value.dot(fit.information * fit.value);
  const CameraFinding found = find_deviations(fit);
  EXPECT_TRUE(found.is(Deviation::kFocal));
  EXPECT_FALSE(found.is(Deviation::kZoom));
  EXPECT_NEAR(found.of(Deviation::kFocal), 0.2, 1e-3);
  EXPECT_NEAR(found.sigma_of(Deviation::kFocal), 0.01, 1e-3) << "as if it were alone";
  EXPECT_NEAR(found.of(Deviation::kZoom), 0.0, 1e-3) << "beside the focal length";
}

TEST(CameraVerdict, AContradictionStandsUntilATestWouldHaveFoundIt) {
  const CameraFinding wrong = find_deviations(fit_of(Deviation::kAspect, 0.05, 0.01));
  const auto right = [](double sigma) {
    return find_deviations(fit_of(Deviation::kAspect, 0.001, sigma));
  };
  ASSERT_TRUE(wrong.is(Deviation::kAspect));
  const CameraFinding kept = joined(wrong, right(0.013));
  EXPECT_TRUE(kept.is(Deviation::kAspect));
  EXPECT_EQ(kept.of(Deviation::kAspect), wrong.of(Deviation::kAspect));
  EXPECT_FALSE(joined(wrong, right(0.012)).any());
  EXPECT_TRUE(joined(right(0.001), wrong).any());
  EXPECT_TRUE(joined(wrong, {}).any());
}

TEST(CameraErrors, AreOfWhatIsContradictedAlone) {
  const CameraError none =
      error_by(find_deviations(fit_of(Deviation::kAspect, 0.03, 0.01)), 0.2, 1.0);
  EXPECT_EQ(none.turn_rad, 0.0);
  EXPECT_EQ(none.aside, 0.0);
  EXPECT_EQ(none.along, 0.0);
  const CameraError by_focal =
      error_by(find_deviations(fit_of(Deviation::kFocal, -0.1, 0.01)), 0.2, 1.0);
  EXPECT_NEAR(by_focal.turn_rad, 0.1 * 0.2, 1e-9);
  EXPECT_NEAR(by_focal.along, 0.1, 1e-9);
  const CameraError by_point =
      error_by(find_deviations(fit_of(Deviation::kPrincipalU, 0.03, 0.001)), 0.2, 1.0);
  EXPECT_NEAR(by_point.turn_rad, 0.03, 1e-9);
  EXPECT_NEAR(by_point.aside, 0.03, 1e-9);
  EXPECT_EQ(by_point.along, 0.0);
  const CameraError by_rows =
      error_by(find_deviations(fit_of(Deviation::kReadout, 0.1, 0.01)), 0.2, 0.5);
  EXPECT_NEAR(by_rows.turn_rad, 0.5 * 0.1 * 0.5, 1e-9);
}

TEST(CameraErrors, WidenAPose) {
  PoseCovariance covariance = PoseCovariance::Zero();
  widen({.turn_rad = 0.1, .aside = 0.02, .along = 0.0}, 5.0, &covariance);
  EXPECT_NEAR(covariance(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(covariance(4, 4), 0.01, 1e-12);
}

}  // namespace
}  // namespace polhode::camera_verdict_test
