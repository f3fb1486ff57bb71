// Hypotheses for the start of a map: where each comes from, and its refinement on a core of frames
// and tracks.
#pragma once

#include <cstdint>
#include <span>

#include "initialisation/hypothesis.hpp"

namespace polhode {

struct SeedProblem {
  std::span<const double> times_s;           ///< all frames
  std::span<const StartSighting> sightings;  ///< contest tracks, ordered by track, then frame
  std::size_t contest_tracks = 0;
  const StartCore* core = nullptr;
  std::uint64_t seed = 0;
  std::uint32_t kinds = kAllKinds;
};

/// Hypotheses of each kind asked for, posed in the core's frames, with the core's tracks known.
void seed_hypotheses(const SeedProblem& problem, StartHypotheses* seeds);

/// Same geometry: points of the first camera's axes within `tolerance` extents (median), and turns
/// between frames within `tolerance` of the largest. Both in the gauge of normalise_gauge.
bool same_geometry(const StartHypothesis& a, const StartHypothesis& b, double tolerance);

}  // namespace polhode
