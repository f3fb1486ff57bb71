// Seeds of the hypothesis selection, and the comparison of two geometries.
#pragma once

#include <cstdint>
#include <span>

#include "initialisation/hypothesis.hpp"

namespace polhode {

struct SeedProblem {
  std::span<const double> times_s;  ///< all frames
  std::span<const TrackObservation>
      observations;  ///< of the selection's tracks, ordered by track, then frame
  std::size_t selection_tracks = 0;
  const InitialCore* core = nullptr;
  std::uint64_t seed = 0;
  std::uint32_t kinds = kAllKinds;
};

/// Hypotheses of each requested kind, with the poses of the core's frames and the core's points.
void seed_hypotheses(const SeedProblem& problem, InitialHypotheses* seeds);

/// Same geometry: the median point differs by `tolerance` extents at most, and rotations between
/// frames by `tolerance` of the largest. Both in the gauge of normalise_gauge.
bool same_geometry(const InitialHypothesis& a, const InitialHypothesis& b, double tolerance);

}  // namespace polhode
