#include "motion/stamp_doubt.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"
#include "geometry/so3.hpp"

namespace polhode {
namespace {

// As the history of arrivals has it: several bursts of the usual four frames.
constexpr std::size_t kIntervals = 15;
constexpr std::size_t kIntervalsMin = 4;  // a burst and the pause after it

struct Interval {
  double seconds = 0.0;
  Eigen::Vector3d turn_T = Eigen::Vector3d::Zero();
  double sigma_rad = 0.0;
};

using Intervals = FixedVector<Interval, kIntervals>;

Intervals intervals_of(std::span<const PoseSample> poses) {
  Intervals intervals;
  for (std::size_t i = 1; i < poses.size() && !intervals.full(); ++i) {
    const PoseSample& from = poses[i - 1];
    const PoseSample& to = poses[i];
    const double variance = (from.covariance + to.covariance).topLeftCorner<3, 3>().trace();
    (void)intervals.push_back({.seconds = seconds_between(from.timestamp_ns, to.timestamp_ns),
                               .turn_T = so3_log(from.pose.R_CT.transpose() * to.pose.R_CT),
                               .sigma_rad = std::sqrt(std::max(0.0, variance))});
  }
  return intervals;
}

/// The lower quartile of the intervals.
double usual_s(const Intervals& intervals) {
  std::array<double, kIntervals> seconds{};
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    seconds[i] = intervals[i].seconds;
  }
  return ranked(std::span(seconds).first(intervals.size()), intervals.size() / 4);
}

/// Are two rotations equal, to a part of their size? Only where both are significant.
bool alike(const Interval& a, const Interval& b) {
  constexpr double kPart = 0.3;    // a tumbling body's rate changes by less from frame to frame
  constexpr double kSigmas = 4.0;  // one turn in ten thousand of noise alone is larger
  const double turn = std::min(a.turn_T.norm(), b.turn_T.norm());
  return turn > kSigmas * std::max(a.sigma_rad, b.sigma_rad) &&
         (a.turn_T - b.turn_T).norm() < kPart * turn;
}

StampDoubt doubt_of(std::span<const PoseSample> poses) {
  constexpr double kFar = 6.0;  // four frames in a row that are lost make no such interval
  const Intervals intervals = intervals_of(poses);
  if (intervals.size() < kIntervalsMin) {
    return {};
  }
  StampDoubt doubt{
      .contradicted = false, .shortest_s = intervals[0].seconds, .longest_s = intervals[0].seconds};
  const double far_s = kFar * usual_s(intervals);
  bool all_alike = true;
  bool any = false;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const Interval& here = intervals[i];
    doubt.shortest_s = std::min(doubt.shortest_s, here.seconds);
    doubt.longest_s = std::max(doubt.longest_s, here.seconds);
    const Interval& beside = intervals[i > 0 ? i - 1 : i + 1];
    if (here.seconds > far_s && beside.seconds < far_s) {
      any = true;
      all_alike = all_alike && alike(here, beside);
    }
  }
  doubt.contradicted = any && all_alike;
  return doubt;
}

}  // namespace

StampDoubt doubt_of_stamps(std::span<const PoseSample> history) {
  return doubt_of(history.last(std::min(history.size(), kIntervals + 1)));
}

StampDoubt doubt_of_stamps_about(std::span<const PoseSample> history, std::size_t index) {
  const std::size_t count = std::min(history.size(), kIntervals + 1);
  const std::size_t before = std::min(index, count / 2);
  const std::size_t first = std::min(index - before, history.size() - count);
  return doubt_of(history.subspan(first, count));
}

}  // namespace polhode
