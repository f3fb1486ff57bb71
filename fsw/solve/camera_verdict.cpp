#include "solve/camera_verdict.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/validity.hpp"

namespace polhode {
namespace {

using Members = std::array<std::uint8_t, kDeviations>;

/// Deviations that are tested together.
struct Kind {
  Deviation first;
  std::size_t count = 1;
  double least = 0.0;  ///< a smaller deviation does not contradict
};
// Least focal deviation: with right cameras it is up to 1.9 % where the sigma is under 2 %
// (decision 0083).
constexpr double kFocalLeast = 0.08;
constexpr std::array<Kind, 6> kKinds = {{{Deviation::kFocal, 1, kFocalLeast},
                                         {Deviation::kZoom, 1, kFocalLeast},
                                         {Deviation::kAspect},
                                         {Deviation::kPrincipalU, 2},
                                         {Deviation::kReadout},
                                         {Deviation::kHalf}}};

/// Chi-square, by degrees of freedom, that a right camera exceeds in one test of 16,000: four
/// sigma.
constexpr std::array<double, 3> kChi2Max = {0.0, 16.0, 19.3};

Members with(Members members, const Kind& kind, std::uint8_t free = 1) {
  std::fill_n(members.begin() + static_cast<std::ptrdiff_t>(kind.first), kind.count, free);
  return members;
}

/// Minimum of the fit's quadratic form where only the members are free.
struct Explained {
  Deviations value = Deviations::Zero();
  Deviations sigma = Deviations::Zero();
  double chi2 = 0.0;  ///< fall of chi-square
};

Explained explained_by(const Members& members, const CameraFit& fit) {
  DeviationInformation A = fit.information;
  Deviations b = fit.information * fit.value;
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    if (members[static_cast<std::size_t>(i)] == 0) {
      A.row(i).setZero();
      A.col(i).setZero();
      A(i, i) = 1.0;
      b[i] = 0.0;
    }
  }
  const DeviationInformation covariance = A.inverse();
  Explained found;
  found.value = covariance * b;
  found.sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  found.chi2 = b.dot(found.value);
  return found;
}

bool has(const Members& members, const Kind& kind) {
  return members[static_cast<std::size_t>(kind.first)] != 0;
}

Members all_kinds() {
  Members all{};
  all.fill(1);
  return all;
}

/// Fixes the kind of deviation that explains least, one after the other, until each explains more
/// than chance would. No kind explains more than the fall of the cost: the quadratic form is exact
/// at the fit's end only.
Members backward_elimination(const CameraFit& fit) {
  Members members = all_kinds();
  while (true) {
    const double now = explained_by(members, fit).chi2;
    const Kind* least = nullptr;
    double least_part = 1.0;  // ratio of a kind's gain to the limit by chance
    for (const Kind& kind : kKinds) {
      if (has(members, kind)) {
        const double loss = now - explained_by(with(members, kind, 0), fit).chi2;
        const double part = std::min(loss, fit.gain) / kChi2Max[kind.count];
        if (!(part > least_part)) {
          least_part = part;
          least = &kind;
        }
      }
    }
    if (least == nullptr) {
      return members;
    }
    members = with(members, *least, 0);
  }
}

double part_of(const CameraFinding& found, Deviation deviation) {
  return found.is(deviation) ? std::abs(found.of(deviation)) : 0.0;
}

}  // namespace

bool CameraFinding::any() const {
  return std::any_of(contradicted.begin(), contradicted.end(), [](auto one) { return one != 0; });
}

CameraFinding find_deviations(const CameraFit& fit) {
  CameraFinding found;
  if (!fit.usable) {
    return found;
  }
  found.rates = fit.rates;
  const Members members = backward_elimination(fit);
  for (const Kind& kind : kKinds) {
    const Explained beside = explained_by(with(members, kind), fit);
    const auto first = static_cast<Eigen::Index>(kind.first);
    const auto count = static_cast<Eigen::Index>(kind.count);
    found.value.segment(first, count) = beside.value.segment(first, count);
    found.sigma.segment(first, count) = beside.sigma.segment(first, count);
    if (has(members, kind) && found.value.segment(first, count).norm() > kind.least) {
      found.contradicted = with(found.contradicted, kind);
    }
  }
  return found;
}

CameraFinding joined(const CameraFinding& earlier, const CameraFinding& later) {
  CameraFinding held = later;
  if (later.any()) {
    return held;
  }
  for (const Kind& kind : kKinds) {
    const auto first = static_cast<Eigen::Index>(kind.first);
    const auto count = static_cast<Eigen::Index>(kind.count);
    const auto before = earlier.value.segment(first, count);
    const double chi2 = before.cwiseQuotient(later.sigma.segment(first, count)).squaredNorm();
    const bool would_be_found = chi2 > kChi2Max[kind.count] && std::isfinite(chi2);
    if (has(earlier.contradicted, kind) && !would_be_found) {
      held.contradicted = with(held.contradicted, kind);
      held.value.segment(first, count) = before;
      held.sigma.segment(first, count) = earlier.sigma.segment(first, count);
      held.rates = earlier.rates;
    }
  }
  return held;
}

bool is_valid(const CameraFinding& found) {
  for (const Kind& kind : kKinds) {
    const auto* first = &found.contradicted[static_cast<std::size_t>(kind.first)];
    const auto alike = std::count(first, first + kind.count, *first);
    if (*first > 1 || alike != static_cast<std::ptrdiff_t>(kind.count)) {
      return false;
    }
  }
  return validity::is_bounded(found.value) && validity::is_bounded(found.sigma) &&
         validity::is_bounded(std::exp(found.value.head<3>().cwiseAbs().maxCoeff())) &&
         found.sigma.minCoeff() >= 0.0 && validity::is_at_least(found.rates.turn_rad_s, 0.0) &&
         validity::is_at_least(found.rates.shift_s, 0.0);
}

DeviationText describe(Deviation deviation, const CameraFinding& found, const CameraModel& c) {
  const double value = found.of(deviation);
  const double sigma = found.sigma_of(deviation);
  const double stated_s = c.line_time_s * c.height_px;
  const auto of_log = [&](std::string_view name, double stated) -> DeviationText {
    return {name, stated, stated * std::exp(value), stated * std::exp(value) * sigma};
  };
  switch (deviation) {
    case Deviation::kFocal:
      return of_log("focal length [px]", c.focal_px());
    case Deviation::kZoom:
      return of_log("zoom (last over first)", 1.0);
    case Deviation::kAspect:
      return of_log("ratio fv / fu", c.fv_px / c.fu_px);
    case Deviation::kPrincipalU:
      return {"principal point [px]", c.cu_px, c.cu_px + value * c.fu_px, sigma * c.fu_px};
    case Deviation::kPrincipalV:
      return {"principal point [px]", c.cv_px, c.cv_px + value * c.fv_px, sigma * c.fv_px};
    case Deviation::kReadout:
      return {"time of all rows [s]", stated_s, stated_s + value, sigma};
    case Deviation::kHalf:
      break;
  }
  return {"age of the upper half [s]", 0.0, value, sigma};
}

CameraError error_by(const CameraFinding& found, double size) {
  const double zoom = part_of(found, Deviation::kZoom);
  // With a zoom the deviation of the mean focal length counts, too, even where it is insignificant.
  const double focal = (zoom > 0.0 ? std::abs(found.of(Deviation::kFocal)) + 0.5 * zoom
                                   : part_of(found, Deviation::kFocal));
  const double aspect = part_of(found, Deviation::kAspect);
  const double point =
      std::hypot(part_of(found, Deviation::kPrincipalU), part_of(found, Deviation::kPrincipalV));
  // Rows are off by at most half of the time, before or after the middle row.
  const double late_s =
      0.5 * (part_of(found, Deviation::kReadout) + part_of(found, Deviation::kHalf));
  return {.attitude_rad = focal * size + aspect + point + late_s * found.rates.turn_rad_s,
          .across = point + aspect * size + late_s * found.rates.shift_s,
          .along = focal + 0.5 * aspect};
}

void widen(const CameraError& error, double range, PoseCovariance* covariance) {
  widen_attitude(error.attitude_rad, covariance);
  widen_position(error.across * range, covariance);
}

}  // namespace polhode
