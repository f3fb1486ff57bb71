#include "solve/camera_verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace polhode::camera_verdict_test {
namespace {

/// A fit whose deviations have independent errors; the cost falls as its quadratic form indicates.
CameraFit fit_of(const Deviations& value, const Deviations& sigma) {
  const Deviations weight = sigma.cwiseAbs2().cwiseInverse();
  return {.usable = true,
          .value = value,
          .information = DeviationInformation(weight.asDiagonal()),
          .gain = value.dot(weight.cwiseProduct(value)),
          .rates = {.turn_rad_s = 0.5, .shift_s = 0.02}};
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

TEST(CameraVerdict, SeveralAreReportedTogether) {
  Deviations value = Deviations::Zero();
  value[2] = 0.05;
  value[5] = 0.041;
  const CameraFinding found = find_deviations(fit_of(value, Deviations::Constant(0.01)));
  EXPECT_TRUE(found.is(Deviation::kAspect));
  EXPECT_TRUE(found.is(Deviation::kReadout));
}

TEST(CameraVerdict, OfNoNumbersNothingIsReported) {
  CameraFit fit = fit_of(Deviation::kAspect, 0.1, 0.001);
  fit.information.setConstant(std::nan(""));
  EXPECT_FALSE(find_deviations(fit).any());
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

TEST(CameraVerdict, APrincipalPointStandsAndFallsAsOne) {
  Deviations value = Deviations::Zero();
  value[3] = 0.0225;
  value[4] = 0.002;
  const CameraFinding wrong = find_deviations(fit_of(value, Deviations::Constant(0.004)));
  ASSERT_TRUE(wrong.is(Deviation::kPrincipalU) && wrong.is(Deviation::kPrincipalV));
  const CameraFit right = fit_of(Deviations::Zero(), Deviations::Constant(0.004));
  EXPECT_FALSE(joined(wrong, find_deviations(right)).any());
}

TEST(CameraVerdict, ALaterContradictionIsHeldAlone) {
  const CameraFinding zoom = find_deviations(fit_of(Deviation::kZoom, 0.25, 0.02));
  const CameraFinding focal = find_deviations(fit_of(Deviation::kFocal, 0.2, 0.07));
  ASSERT_FALSE(focal.any());
  EXPECT_TRUE(joined(zoom, focal).is(Deviation::kZoom));
  const CameraFinding sure = find_deviations(fit_of(Deviation::kFocal, 0.4, 0.07));
  EXPECT_TRUE(joined(zoom, sure).is(Deviation::kFocal));
  EXPECT_FALSE(joined(zoom, sure).is(Deviation::kZoom)) << "they may be one";
}

TEST(CameraVerdict, IsValidAsItIsFound_AndNotDamaged) {
  const CameraFinding found = find_deviations(fit_of(Deviation::kPrincipalU, 0.05, 0.01));
  ASSERT_TRUE(found.any());
  EXPECT_TRUE(is_valid(found));
  EXPECT_TRUE(is_valid(CameraFinding{}));
  const auto is_valid_after = [&](const auto& damage) {
    CameraFinding damaged = found;
    damage(&damaged);
    return is_valid(damaged);
  };
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->value[2] = 1e200; }));
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->value[0] = -1000.0; })) << "no factor";
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->value[6] = std::nan(""); }));
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->sigma[0] = -1.0; }));
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->contradicted[4] = 0; })) << "half a point";
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->contradicted[0] = 2; }));
  EXPECT_FALSE(is_valid_after([](CameraFinding* f) { f->rates.turn_rad_s = 1e99; }));
}

CameraError error_of(Deviation deviation, double value) {
  return error_by(find_deviations(fit_of(deviation, value, 0.01)), 0.2);
}

TEST(CameraErrors, AreOfWhatIsContradictedAlone) {
  const CameraError none = error_of(Deviation::kAspect, 0.03);
  EXPECT_EQ(none.attitude_rad, 0.0);
  EXPECT_EQ(none.across, 0.0);
  EXPECT_EQ(none.along, 0.0);
  const CameraError by_focal = error_of(Deviation::kFocal, -0.1);
  EXPECT_NEAR(by_focal.attitude_rad, 0.1 * 0.2, 1e-9);
  EXPECT_EQ(by_focal.across, 0.0);
  EXPECT_NEAR(by_focal.along, 0.1, 1e-9);
  const CameraError by_aspect = error_of(Deviation::kAspect, 0.1);
  EXPECT_NEAR(by_aspect.attitude_rad, 0.1, 1e-9);
  EXPECT_NEAR(by_aspect.across, 0.1 * 0.2, 1e-9);
  EXPECT_NEAR(by_aspect.along, 0.05, 1e-9);
  for (const Deviation one : {Deviation::kReadout, Deviation::kHalf}) {
    const CameraError by_rows = error_of(one, 0.1);
    EXPECT_NEAR(by_rows.attitude_rad, 0.5 * 0.1 * 0.5, 1e-9);
    EXPECT_NEAR(by_rows.across, 0.5 * 0.1 * 0.02, 1e-9);
    EXPECT_EQ(by_rows.along, 0.0);
  }
}

TEST(CameraErrors, OfAPrincipalPointAreOfItsDistance) {
  Deviations value = Deviations::Zero();
  value[3] = 0.03;
  value[4] = -0.04;
  const CameraError error =
      error_by(find_deviations(fit_of(value, Deviations::Constant(0.001))), 0.2);
  EXPECT_NEAR(error.attitude_rad, 0.05, 1e-9);
  EXPECT_NEAR(error.across, 0.05, 1e-9);
  EXPECT_EQ(error.along, 0.0);
}

TEST(CameraErrors, OfAZoomHoldItsMiddleThatIsNotToldByItself) {
  Deviations value = Deviations::Zero();
  value[0] = 0.07;
  value[1] = 0.14;
  const CameraFinding found = find_deviations(fit_of(value, Deviations::Constant(0.01)));
  ASSERT_TRUE(found.is(Deviation::kZoom));
  ASSERT_FALSE(found.is(Deviation::kFocal));
  EXPECT_NEAR(error_by(found, 0.0).along, 0.14, 1e-9);
}

TEST(CameraErrors, WidenAPose) {
  PoseCovariance covariance = PoseCovariance::Zero();
  widen({.attitude_rad = 0.1, .across = 0.02, .along = 0.0}, 5.0, &covariance);
  EXPECT_NEAR(covariance(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(covariance(4, 4), 0.01, 1e-12);
}

TEST(CameraTexts, AreInPeoplesUnits) {
  constexpr CameraModel kCamera{.fu_px = 1000.0, .fv_px = 1000.0, .cu_px = 320.0, .cv_px = 240.0};
  const auto text = [&](Deviation deviation, double value) {
    return describe(deviation, find_deviations(fit_of(deviation, value, 0.01)), kCamera);
  };
  EXPECT_NEAR(text(Deviation::kFocal, std::log(1.2)).fits, 1200.0, 1e-6);
  EXPECT_NEAR(text(Deviation::kFocal, std::log(1.2)).sigma, 12.0, 1e-6);
  EXPECT_EQ(text(Deviation::kFocal, 0.2).stated, 1000.0);
  EXPECT_NEAR(text(Deviation::kZoom, std::log(1.3)).fits, 1.3, 1e-9);
  EXPECT_NEAR(text(Deviation::kAspect, std::log(0.9)).fits, 0.9, 1e-9);
  EXPECT_NEAR(text(Deviation::kPrincipalU, 0.06).fits, 380.0, 1e-6);
  EXPECT_NEAR(text(Deviation::kPrincipalV, 0.06).fits, 300.0, 1e-6);
  EXPECT_NEAR(text(Deviation::kReadout, 0.06).fits, 0.06, 1e-9);
  EXPECT_NEAR(text(Deviation::kHalf, -0.06).fits, -0.06, 1e-9);
  CameraModel rolling = kCamera;
  rolling.height_px = 480;
  rolling.line_time_s = 1e-4;
  const auto found = find_deviations(fit_of(Deviation::kReadout, 0.06, 0.01));
  EXPECT_NEAR(describe(Deviation::kReadout, found, rolling).stated, 0.048, 1e-9);
  EXPECT_NEAR(describe(Deviation::kReadout, found, rolling).fits, 0.108, 1e-9);
}

}  // namespace
}  // namespace polhode::camera_verdict_test
