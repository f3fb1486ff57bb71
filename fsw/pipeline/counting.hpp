// Adds the rooms' own counts to the component's counters.
#pragma once

#include "bus/counters.hpp"
#include "image/frame_use.hpp"
#include "image/verdict.hpp"

namespace polhode {

struct JobCounts;
struct MapCounts;
struct ScaleChange;

/// Counts the use of a frame and the fault of its image.
void count(FrameUse use, const FrameVerdict& verdict, Counters* counters);

/// A reading of the scale. @return it was read.
bool count(const ScaleChange& change, Counters* counters);

/// Adds the rooms' counts and resets them to zero.
void take_counts(MapCounts* map, JobCounts* jobs, Counters* counters);

}  // namespace polhode
