#include "motion/local_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/fixed_vector.hpp"
#include "geometry/so3.hpp"
#include "motion/model_average.hpp"

namespace polhode {
namespace {

// At 1.5 rad from the reference the first missing term is A 1.5^7 / 7!, 0.3 % of A.
constexpr int kDegree = 6;
constexpr int kLocalRotationUnknowns = 3 * (kDegree + 1);
constexpr int kLocalTranslationUnknowns = 12;  // g, v, a, c

// Deviations from a constant rate, in parts of the rate: from none to the largest of a free body.
// There |dw/dt| <= |w|^2 / sqrt(3), because (I_j - I_k) / I_i <= 1. The list is coarse: averaging
// the fits by their evidence interpolates between its values.
constexpr std::array<double, 6> kBends{1e-4, 0.01, 0.03, 0.1, 0.3, 1.0};
// Keeps the prior proper for a body at rest: a bend of less than a milliradian over the series is
// below the noise of poses.
constexpr double kArcMin_rad = 1e-3;
// Centre-of-mass offsets from T's origin in parts of the range: of a distant body or a well centred
// one, a typical one, and one that fills the view and is lopsided. Chosen a decade apart.
constexpr std::array<double, 3> kCentreOffsets{3e-4, 3e-3, 3e-2};
// Deviations of the centre of mass from a straight line over the window, in parts of the range. A
// free body has none over minutes, a braked or a hand-carried one has. Chosen.
constexpr std::array<double, 3> kDepartures{1e-7, 1e-4, 1e-2};

template <typename Point>
double span_of(std::span<const Point> points) {
  double span_s = 0.0;
  for (const Point& point : points) {
    span_s = std::max(span_s, std::abs(point.tau_s));
  }
  return span_s;
}

/// Prior information of the coefficients of (tau / scale)^k.
ModelVector rotation_prior(double bend, double rotation_rad) {
  ModelVector information = ModelVector::Zero(kLocalRotationUnknowns);
  double sigma = bend * rotation_rad;
  for (int k = 2; k <= kDegree; ++k) {
    sigma *= rotation_rad / k;
    information.segment<3>(3 * k).setConstant(1.0 / (sigma * sigma));
  }
  return information;
}

/// Rows [P_0 I, P_1 I, ...] of powers of the time, or of their derivatives.
ModelRows powers(const LocalTarget& at, double scale_s) {
  ModelRows rows = ModelRows::Zero(3, kLocalRotationUnknowns);
  double power = 1.0;  // (tau / scale)^(k - derivative)
  for (int k = at.derivative; k <= kDegree; ++k) {
    const double factor = at.derivative == 0 ? power : k * power / scale_s;
    rows.block<3, 3>(0, 3 * k) = factor * Eigen::Matrix3d::Identity();
    power *= at.tau_s / scale_s;
  }
  return rows;
}

ModelRows path_rows(double time, const Eigen::Matrix3d& R_from_reference) {
  ModelRows rows = ModelRows::Zero(3, kLocalTranslationUnknowns);
  rows.block<3, 3>(0, 0) = Eigen::Matrix3d::Identity();
  rows.block<3, 3>(0, 3) = time * Eigen::Matrix3d::Identity();
  rows.block<3, 3>(0, 6) = time * time * Eigen::Matrix3d::Identity();
  rows.block<3, 3>(0, 9) = -R_from_reference;
  return rows;
}

ModelRows path_rate_rows(double time,
                         double scale_s,
                         const Eigen::Matrix3d& R_CT,
                         const Eigen::Vector3d& w_T_rad_s) {
  ModelRows rows = ModelRows::Zero(3, kLocalTranslationUnknowns);
  rows.block<3, 3>(0, 3) = Eigen::Matrix3d::Identity() / scale_s;
  rows.block<3, 3>(0, 6) = 2.0 * time / scale_s * Eigen::Matrix3d::Identity();
  rows.block<3, 3>(0, 9) = -(R_CT * hat(w_T_rad_s));
  return rows;
}

LocalFit local_fit(const ModelAnswer& answer, std::size_t points, double span_s) {
  return {.estimate = answer.estimate,
          .covariance = answer.covariance,
          .at_reference = answer.unknowns.head<3>(),
          .points = points,
          .span_s = span_s,
          .misfit = answer.misfit};
}

}  // namespace

Result<LocalFit> fit_rotation(std::span<const RotationPoint> points,
                              double rotation_rad_s,
                              const LocalTarget& target) {
  if (points.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  const double scale_s = span_of(points);
  if (!(scale_s > 0.0) || !std::isfinite(scale_s)) {
    return ErrorCode::kDegenerate;
  }
  ModelData data(kLocalRotationUnknowns);
  for (const RotationPoint& point : points) {
    data.add(
        powers({.tau_s = point.tau_s, .derivative = 0}, scale_s), point.psi_rad, point.information);
  }
  std::array<ModelVector, kBends.size()> priors;
  const double rotation_rad = std::max(kArcMin_rad, rotation_rad_s * scale_s);
  for (std::size_t i = 0; i < kBends.size(); ++i) {
    priors[i] = rotation_prior(kBends[i], rotation_rad);
  }
  const Result<ModelAnswer> answer =
      average_models(data, priors, powers(target, scale_s).transpose());
  if (!answer) {
    return answer.error();
  }
  return local_fit(answer.value(), points.size(), scale_s);
}

Result<LocalFit> fit_translation(std::span<const TranslationPoint> points,
                                 const TranslationTarget& target) {
  if (points.size() < 2) {
    return ErrorCode::kTooFewObservations;
  }
  POLHODE_ASSERT(points[0].tau_s == 0.0, points[0].tau_s);
  const double scale_s = span_of(points);
  const double range = points[0].p_CT.norm();
  if (!(scale_s > 0.0) || !std::isfinite(scale_s) || !(range > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  // Relative to the first position and attitude: small numbers, and the offset drops out where
  // nothing rotates.
  ModelData data(kLocalTranslationUnknowns);
  for (const TranslationPoint& point : points) {
    data.add(path_rows(point.tau_s / scale_s, point.R_CT - points[0].R_CT),
             point.p_CT - points[0].p_CT,
             point.information);
  }
  FixedVector<ModelVector, kCentreOffsets.size() * kDepartures.size()> priors;
  for (const double offset : kCentreOffsets) {
    for (const double departure : kDepartures) {
      ModelVector prior = ModelVector::Zero(kLocalTranslationUnknowns);
      prior.segment<3>(6).setConstant(1.0 / (departure * range * departure * range));
      prior.segment<3>(9).setConstant(1.0 / (offset * range * offset * range));
      POLHODE_ASSERT(priors.push_back(prior), priors.size());
    }
  }
  const double time = target.at.tau_s / scale_s;
  const ModelRows rows = target.at.derivative == 0
                             ? path_rows(time, target.R_CT - points[0].R_CT)
                             : path_rate_rows(time, scale_s, target.R_CT, target.w_T_rad_s);
  const Result<ModelAnswer> answer = average_models(data, priors.view(), rows.transpose());
  if (!answer) {
    return answer.error();
  }
  LocalFit fit = local_fit(answer.value(), points.size(), scale_s);
  fit.at_reference += points[0].p_CT;
  fit.mass_centre_offset_T = answer.value().unknowns.tail<3>();
  if (target.at.derivative == 0) {
    fit.estimate += points[0].p_CT;
  }
  return fit;
}

}  // namespace polhode
