#include "image/arrival.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"

namespace polhode {

int missing_frames(std::int64_t timestamp_ns, ArrivalHistory* history) {
  constexpr std::size_t kIntervalsMin = 3;  // the least whose median is right with one gap
  // Tolerance, in periods; 0.5 would accept any interval. Chosen; larger counts frames that come at
  // no fixed rate, smaller misses those with jitter.
  constexpr double kTolerance = 0.25;
  constexpr double kMissingMax = 1000.0;  // chosen: a longer gap is a pause, not a loss
  const std::int64_t interval_ns = timestamp_ns - history->last_ns;
  const bool first = !history->any;
  if (!first && interval_ns <= 0) {
    return 0;  // delivered again, or late
  }
  history->any = true;
  history->last_ns = timestamp_ns;
  if (first) {
    return 0;
  }
  int missing = 0;
  auto& known = history->intervals_ns;
  if (known.size() >= kIntervalsMin) {
    std::array<std::int64_t, ArrivalHistory::kIntervals> sorted{};
    std::copy(known.begin(), known.end(), sorted.begin());
    const std::int64_t usual_ns = median(std::span(sorted).first(known.size()));
    const double periods = static_cast<double>(interval_ns) / static_cast<double>(usual_ns);
    const double whole = std::round(periods);
    if (whole >= 2.0 && whole < kMissingMax && std::abs(periods - whole) < kTolerance) {
      missing = static_cast<int>(whole) - 1;
    }
  }
  if (known.full()) {
    known.erase(0);
  }
  (void)known.push_back(interval_ns);
  return missing;
}

}  // namespace polhode
