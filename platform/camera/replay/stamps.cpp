#include "camera/replay/stamps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"
#include "errors.hpp"

namespace polhode::platform {
namespace {

struct Unit {
  double nanoseconds;
  const char* name;
};

constexpr std::array<Unit, 3> kOtherUnits = {
    Unit{1e3, "microseconds"}, Unit{1e6, "milliseconds"}, Unit{1e9, "seconds or frame numbers"}};

// Chosen: whole images are taken up to some 10,000 times a second.
constexpr std::int64_t kIntervalMin_ns = 10'000;
// Stamps of another unit are off by it and by little else: clocks are good to 1e-4, and rates are
// written with two digits.
constexpr double kUnitTolerance = 0.02;
// Chosen: every second image left out is reported, a rounded rate is not.
constexpr double kRateFactorMax = 1.5;

std::vector<std::int64_t> intervals_of(std::span<const std::int64_t> stamps_ns) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) {
    intervals.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  }
  return intervals;
}

std::string rate_text(std::optional<double> rate_hz) {
  return rate_hz ? fmt::format("sensor.yaml says rate_hz: {:g}", *rate_hz)
                 : std::string("sensor.yaml names no rate_hz");
}

/// The unit that the stamps are in if the camera's rate is right; none where no other unit fits.
const Unit* other_unit(double interval_ns, double rate_hz) {
  for (const Unit& unit : kOtherUnits) {
    if (std::abs(interval_ns * unit.nanoseconds * 1e-9 * rate_hz - 1.0) < kUnitTolerance) {
      return &unit;
    }
  }
  return nullptr;
}

void refuse_other_units(double interval_ns,
                        std::optional<double> rate_hz,
                        const std::filesystem::path& table) {
  const Unit* unit = rate_hz ? other_unit(interval_ns, *rate_hz) : nullptr;
  if (unit == nullptr && interval_ns >= kIntervalMin_ns) {
    return;
  }
  const std::string looks = unit == nullptr ? "" : fmt::format("; these look like {}", unit->name);
  throw UnusableInput(fmt::format(
      "{}: timestamp [ns]: the pictures are {:g} s apart in the median ({:g} a second), "
      "but {}; allowed are nanoseconds, {} and more apart{}",
      table.string(),
      1e-9 * interval_ns,
      1e9 / interval_ns,
      rate_text(rate_hz),
      kIntervalMin_ns,
      looks));
}

/// Images that are stamped when they arrive come in bursts: many long pauses among short
/// intervals.
std::string bursts(std::span<const std::int64_t> intervals, double median_ns) {
  // Chosen: four frames in a row that are lost make no pause, and pauses are usual in one interval
  // out of thirty.
  constexpr double kPause = 6.0;
  constexpr std::size_t kPausesMin = 3;
  constexpr std::size_t kIntervalsPerPauseMax = 30;
  const auto pauses = static_cast<std::size_t>(
      std::count_if(intervals.begin(), intervals.end(), [&](std::int64_t interval) {
        return static_cast<double>(interval) > kPause * median_ns;
      }));
  if (pauses < kPausesMin || pauses * kIntervalsPerPauseMax < intervals.size()) {
    return "";
  }
  return fmt::format(
      "{} of {} intervals are over {:g} times the median of {:g} s: if these are the "
      "times of arrival, rates are wrong",
      pauses,
      intervals.size(),
      kPause,
      1e-9 * median_ns);
}

/// Frames that are missing among regular intervals, where they are a tenth or leave a long gap.
std::string gaps(std::span<const std::int64_t> stamps_ns,
                 std::span<const std::int64_t> intervals,
                 double median_ns) {
  // Chosen as in tools/polhode_ground/importing/stamps.py: fewer intervals, or such that vary,
  // count no frames.
  constexpr std::size_t kIntervalsMin = 9;
  constexpr double kRegularWidth = 0.25;
  constexpr double kRegularShare = 0.8;
  constexpr double kGap = 1.75;
  // Chosen: a tenth of the frames, or ten at once, over which a target is easily lost.
  constexpr double kMissingShareMin = 0.1;
  constexpr double kLongGap = 10.0;
  std::size_t regular = 0;
  double missing = 0.0;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double times = static_cast<double>(intervals[i]) / median_ns;
    regular += std::abs(times - 1.0) <= kRegularWidth ? 1 : 0;
    missing += times > kGap ? std::round(times) - 1.0 : 0.0;
    longest = intervals[i] > intervals[longest] ? i : longest;
  }
  const auto count = static_cast<double>(intervals.size());
  const double longest_ns = static_cast<double>(intervals[longest]);
  const bool is_regular =
      intervals.size() >= kIntervalsMin && static_cast<double>(regular) >= kRegularShare * count;
  if (!is_regular ||
      (missing < kMissingShareMin * (count + missing) && longest_ns < kLongGap * median_ns)) {
    return "";
  }
  return fmt::format(
      "about {:.0f} frames are missing between the {} that are there, most of them in the {:g} s "
      "after {}: lost, a pause, or a clock that was set ahead",
      missing,
      stamps_ns.size(),
      1e-9 * longest_ns,
      stamps_ns[longest]);
}

bool is_rate(double interval_ns, double rate_hz) {
  const double factor = 1e-9 * interval_ns * rate_hz;
  return factor < kRateFactorMax && factor > 1.0 / kRateFactorMax;
}

/// The file may name the camera's rate or that of its frames in the mean, pauses and all.
std::string other_rate(double median_ns, double mean_ns, std::optional<double> rate_hz) {
  if (!rate_hz || is_rate(median_ns, *rate_hz) || is_rate(mean_ns, *rate_hz)) {
    return "";
  }
  return fmt::format(
      "the pictures are {:g} s apart in the median, but {}: the stamps are gone by, "
      "and all rates with them",
      1e-9 * median_ns,
      rate_text(rate_hz));
}

}  // namespace

std::vector<std::string> stamp_warnings(std::span<const std::int64_t> stamps_ns,
                                        std::optional<double> rate_hz,
                                        const std::filesystem::path& table) {
  const std::vector<std::int64_t> intervals = intervals_of(stamps_ns);
  if (intervals.empty()) {
    return {};
  }
  std::vector<std::int64_t> sorted = intervals;
  const auto median_ns = static_cast<double>(median(std::span(sorted)));
  refuse_other_units(median_ns, rate_hz, table);
  std::vector<std::string> warnings;
  const double mean_ns = static_cast<double>(stamps_ns.back() - stamps_ns.front()) /
                         static_cast<double>(intervals.size());
  const std::string in_bursts = bursts(intervals, median_ns);
  for (const std::string& warning :
       {other_rate(median_ns, mean_ns, rate_hz),
        in_bursts,
        in_bursts.empty() ? gaps(stamps_ns, intervals, median_ns) : std::string()}) {
    if (!warning.empty()) {
      warnings.push_back(fmt::format("{}: timestamp [ns]: {}", table.string(), warning));
    }
  }
  return warnings;
}

std::string readout_warning(std::span<const std::int64_t> stamps_ns, double readout_ns) {
  std::vector<std::int64_t> intervals = intervals_of(stamps_ns);
  if (intervals.empty()) {
    return "";
  }
  const auto median_ns = static_cast<double>(median(std::span(intervals)));
  if (std::abs(readout_ns) <= median_ns) {
    return "";
  }
  return fmt::format(
      "all rows of a picture take {:g} s, but the pictures are {:g} s apart in the median; usual "
      "is less, in nanoseconds from one row to the next",
      1e-9 * std::abs(readout_ns),
      1e-9 * median_ns);
}

}  // namespace polhode::platform
