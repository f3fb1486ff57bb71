#include "map/rate_links.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

// dw/dt over w^2, RMS of an axis, of random free bodies: logarithms of their second moments are 1.5
// apart, as in rigid_model, and rates have any direction (decision 0109).
constexpr double kChange = 0.17;
// Longest turn of a link: over a longer one the mean rate is not that of the middle.
constexpr double kTurnMax_rad = 0.3;

struct Turn {
  double duration_s = 0.0;
  Eigen::Vector3d turn_I = Eigen::Vector3d::Zero();
};

/// Rotation from one of the snapshot's keyframes to another.
Turn turn_between(const AdjustmentSnapshot& s, std::size_t from, std::size_t to) {
  return {.duration_s = 1e-9 * static_cast<double>(s.timestamps_ns[to] - s.timestamps_ns[from]),
          .turn_I = so3_log(s.R_IC[to] * s.poses[to].R_CT *
                            (s.R_IC[from] * s.poses[from].R_CT).transpose())};
}

using Indices = FixedVector<std::size_t, limits::kKeyframes>;

Indices by_time(const AdjustmentSnapshot& s) {
  Indices order;
  order.resize(s.poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return s.keyframe_numbers[a] < s.keyframe_numbers[b];
  });
  return order;
}

bool can_link(const Turn& turn) {
  return turn.duration_s > 0.0 && turn.turn_I.norm() < kTurnMax_rad;
}

/// Are both of one motion? Else the number of revolutions between them is unknown, as over an hour
/// between two passes.
bool go_on(const Turn& a, const Turn& b) {
  // A right angle, by the other's rate: a half turn back looks like one ahead.
  constexpr double kMost_rad = 1.57;
  const auto by_rate_of = [](const Turn& rate, const Turn& over) {
    return rate.turn_I.norm() / rate.duration_s * over.duration_s;
  };
  return by_rate_of(a, b) < kMost_rad && by_rate_of(b, a) < kMost_rad;
}

/// Predicts dw/dt over the last two turns as that over the two before, decayed by a factor of e per
/// radian. On random free bodies half of it is left after a radian. Without decay a disturbance
/// could not be followed; with an instant one an arc could bend. Without two earlier turns the
/// prediction is zero.
RateLink link_of(const Turn* before, const Turn& first, const Turn& second) {
  const double span_s = first.duration_s + second.duration_s;
  const double rate_rad_s =
      std::hypot((first.turn_I + second.turn_I).norm(), RateLink::kTurnLeast_rad) / span_s;
  double sigma = kChange * rate_rad_s * rate_rad_s;
  RateLink link;
  Eigen::Vector3d whole_I = first.turn_I + second.turn_I;
  if (before != nullptr) {
    const double kept = std::exp(-rate_rad_s * first.duration_s);
    sigma *= std::sqrt(1.0 - kept * kept);
    const double by_earlier = 2.0 * kept / ((before->duration_s + first.duration_s) * sigma);
    link.factors_1_rad[0] = by_earlier / before->duration_s;
    link.factors_1_rad[1] = -by_earlier / first.duration_s;
    whole_I += before->turn_I;
  }
  const std::size_t m = before != nullptr ? 1 : 0;
  const double by_change = 2.0 / (span_s * sigma);
  link.factors_1_rad[m] -= by_change / first.duration_s;
  link.factors_1_rad[m + 1] = by_change / second.duration_s;
  link.turn_rad = std::hypot(whole_I.norm(), RateLink::kTurnLeast_rad);
  return link;
}

}  // namespace

void add_rate_links(AdjustmentSnapshot* s) {
  const Indices order = by_time(*s);
  for (std::size_t n = 2; n < order.size(); ++n) {
    const Turn first = turn_between(*s, order[n - 2], order[n - 1]);
    const Turn second = turn_between(*s, order[n - 1], order[n]);
    if (!can_link(first) || !can_link(second) || !go_on(first, second)) {
      continue;
    }
    const Turn before = n > 2 ? turn_between(*s, order[n - 3], order[n - 2]) : Turn{};
    const bool goes_on = can_link(before) && go_on(before, first);
    RateLink link = link_of(goes_on ? &before : nullptr, first, second);
    bool any_free = false;
    for (std::size_t k = goes_on ? n - 3 : n - 2; k <= n; ++k) {
      (void)link.poses.push_back(static_cast<std::int32_t>(order[k]));
      any_free = any_free || s->pose_fixed[order[k]] == 0;
    }
    if (any_free) {
      (void)s->motion.links.push_back(link);
    }
  }
}

}  // namespace polhode
