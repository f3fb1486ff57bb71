#include "solve/sine_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "solve/small_fit.hpp"

namespace polhode {
namespace {

// Twice the four unknowns.
constexpr std::size_t kSamplesMin = 8;
// Largest grid: from 1000 samples on it is coarser than kGridPerLine.
constexpr int kGridMax = 4000;
constexpr int kGridMin = 16;
// Grid points in the width of a spectral line: the best one lies within the basin of the sine.
constexpr double kGridPerLine = 8.0;
// Steps from the grid's best. Chosen: a few settle.
constexpr int kStepsMax = 20;
// Least significance. In noise an amplitude of five sigma has a probability of exp(-12.5) at one
// frequency, 0.4 % at a thousand.
constexpr double kAmplitudeSigmasMin = 5.0;
// Least ratio of pivots: below it offset and sine are not separated.
constexpr double kPivotMin = 1e-9;
// Half angles under which a series replaces the formula, which loses digits. Its next term is 2e-13
// of the attenuation, 1e-7 of the slope.
constexpr double kSeries_rad = 1e-6;
constexpr double kSlopeSeries_rad = 1e-3;
// Tolerance, relative to an interval, for intervals that touch: rounding of the time stamps.
constexpr double kTouch = 1e-3;
// Avoids a division by zero.
constexpr double kAmplitudeMin = 1e-300;

/// Parameters: offset, cosine part, sine part, angular rate.
using Parameters = Eigen::Vector4d;

/// Attenuation: the mean of a sine over `interval_s` is the sine in the middle times this.
double attenuation(double rate_rad_s, double interval_s) {
  const double half = 0.5 * rate_rad_s * interval_s;
  return half > kSeries_rad ? std::sin(half) / half : 1.0;
}

double attenuation_slope(double rate_rad_s, double interval_s) {
  const double half = 0.5 * rate_rad_s * interval_s;
  if (half < kSlopeSeries_rad) {
    return -half * interval_s / 6.0;
  }
  return 0.5 * interval_s * (std::cos(half) / half - std::sin(half) / (half * half));
}

/// Linear least squares of offset and sine at a fixed rate.
bool fit_at(std::span<const SineSample> samples,
            double rate_rad_s,
            Eigen::Vector3d* linear,
            double* chi2) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  double square = 0.0;
  for (const SineSample& sample : samples) {
    const double angle = rate_rad_s * (sample.time_s - samples[0].time_s);
    const double damp = attenuation(rate_rad_s, sample.interval_s);
    const double weight = 1.0 / (sample.sigma * sample.sigma);
    const Eigen::Vector3d J(1.0, damp * std::cos(angle), damp * std::sin(angle));
    H += weight * J * J.transpose();
    g += weight * J * sample.value;
    square += weight * sample.value * sample.value;
  }
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(H);
  if (!(ldlt.vectorD().minCoeff() > kPivotMin * ldlt.vectorD().maxCoeff())) {
    return false;
  }
  *linear = ldlt.solve(g);
  *chi2 = square - g.dot(*linear);
  return linear->allFinite();
}

/// The rate of least chi-square on the grid. False when none is usable.
bool search(std::span<const SineSample> samples, double span_s, Parameters* best) {
  const double mean_interval_s = span_s / static_cast<double>(samples.size() - 1);
  const double rate_min = std::numbers::pi / span_s;  // half a period in the span
  const double rate_max = std::numbers::pi / mean_interval_s;
  const int steps = std::clamp(
      static_cast<int>((rate_max - rate_min) * span_s / (2.0 * std::numbers::pi) * kGridPerLine),
      kGridMin,
      kGridMax);
  bool found = false;
  double chi2_best = 0.0;
  for (int i = 0; i <= steps; ++i) {
    const double rate = rate_min + (rate_max - rate_min) * i / steps;
    Eigen::Vector3d linear;
    double chi2 = 0.0;
    if (fit_at(samples, rate, &linear, &chi2) && (!found || chi2 < chi2_best)) {
      *best << linear, rate;
      chi2_best = chi2;
      found = true;
    }
  }
  return found;
}

Parameters jacobian(const Parameters& p, const SineSample& sample, double start_s) {
  const double time = sample.time_s - start_s;
  const double damp = attenuation(p(3), sample.interval_s);
  const double cosine = std::cos(p(3) * time);
  const double sine = std::sin(p(3) * time);
  const double wave = p(1) * cosine + p(2) * sine;
  return {1.0,
          damp * cosine,
          damp * sine,
          damp * time * (p(2) * cosine - p(1) * sine) +
              attenuation_slope(p(3), sample.interval_s) * wave};
}

double residual(const Parameters& p, const SineSample& sample, double start_s) {
  const double angle = p(3) * (sample.time_s - start_s);
  const double damp = attenuation(p(3), sample.interval_s);
  return sample.value - p(0) - damp * (p(1) * std::cos(angle) + p(2) * std::sin(angle));
}

using System = SmallEquations<4>;

/// @return false where the rate is not positive.
bool linearise(std::span<const SineSample> samples, const Parameters& p, System* at) {
  *at = {};
  for (const SineSample& sample : samples) {
    const double weight = 1.0 / (sample.sigma * sample.sigma);
    const Parameters J = jacobian(p, sample, samples[0].time_s);
    const double r = residual(p, sample, samples[0].time_s);
    at->H += weight * J * J.transpose();
    at->g -= weight * J * r;
    at->cost += weight * r * r;
  }
  return p(3) > 0.0;
}

/// Covariance of the least-squares parameters by the true noise: successive samples that share a
/// pose correlate by -1/2.
Eigen::Matrix4d sandwich(std::span<const SineSample> samples,
                         const Parameters& p,
                         const Eigen::Matrix4d& inverse_H) {
  Eigen::Matrix4d middle = Eigen::Matrix4d::Zero();
  Parameters previous = Parameters::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Parameters J = jacobian(p, samples[i], samples[0].time_s) / samples[i].sigma;
    middle += J * J.transpose();
    if (i > 0) {
      const double apart_s = samples[i].time_s - samples[i - 1].time_s;
      const double touch_s = 0.5 * (samples[i].interval_s + samples[i - 1].interval_s);
      if (touch_s > 0.0 && std::abs(apart_s - touch_s) < kTouch * touch_s) {
        middle -= 0.5 * (J * previous.transpose() + previous * J.transpose());
      }
    }
    previous = J;
  }
  return inverse_H * middle * inverse_H;
}

SineFit describe(const Parameters& p, const Eigen::Matrix4d& covariance, double span_s) {
  SineFit fit;
  fit.offset = p(0);
  fit.amplitude = std::hypot(p(1), p(2));
  fit.period_s = 2.0 * std::numbers::pi / p(3);
  fit.phase_rad = std::atan2(p(1), p(2));
  const Eigen::Vector2d along = p.segment<2>(1) / std::max(fit.amplitude, kAmplitudeMin);
  const Eigen::Vector2d across(along.y(), -along.x());
  const Eigen::Matrix2d wave = covariance.block<2, 2>(1, 1);
  fit.sigma_offset = std::sqrt(std::max(0.0, covariance(0, 0)));
  fit.sigma_amplitude = std::sqrt(std::max(0.0, along.dot(wave * along)));
  fit.sigma_phase_rad =
      std::sqrt(std::max(0.0, across.dot(wave * across))) / std::max(fit.amplitude, kAmplitudeMin);
  fit.sigma_period_s = fit.period_s / p(3) * std::sqrt(std::max(0.0, covariance(3, 3)));
  fit.observed =
      fit.period_s <= span_s && fit.amplitude > kAmplitudeSigmasMin * fit.sigma_amplitude;
  return fit;
}

}  // namespace

Result<SineFit> fit_sine(std::span<const SineSample> samples) {
  if (samples.size() < kSamplesMin) {
    return ErrorCode::kTooFewObservations;
  }
  const double span_s = samples.back().time_s - samples.front().time_s;
  const bool usable = std::all_of(samples.begin(), samples.end(), [](const SineSample& sample) {
    return sample.sigma > 0.0 && std::isfinite(sample.sigma) && std::isfinite(sample.value);
  });
  Parameters p;
  if (!(span_s > 0.0) || !usable || !search(samples, span_s, &p)) {
    return ErrorCode::kDegenerate;
  }
  System system;
  const auto at = [&](const Parameters& trial, System* equations) {
    return linearise(samples, trial, equations);
  };
  if (minimise(at, {.steps_max = kStepsMax}, &p, &system) < 0) {
    return ErrorCode::kDegenerate;
  }
  const Eigen::Matrix4d inverse_H = system.H.inverse();
  if (!inverse_H.allFinite()) {
    return ErrorCode::kDegenerate;
  }
  const double chi2_per_dof = system.cost / static_cast<double>(samples.size() - 4);
  SineFit fit = describe(p, std::max(1.0, chi2_per_dof) * sandwich(samples, p, inverse_H), span_s);
  double square = 0.0;
  for (const SineSample& sample : samples) {
    square += std::pow(residual(p, sample, samples[0].time_s), 2);
  }
  fit.rms = std::sqrt(square / static_cast<double>(samples.size()));
  return fit;
}

}  // namespace polhode
