// What the rooms count by themselves goes into the component's counters.
#pragma once

#include "bus/counters.hpp"
#include "image/frame_use.hpp"
#include "image/verdict.hpp"

namespace polhode {

struct JobCounts;
struct MapCounts;
struct ScaleChange;

/// What became of a frame, and what was wrong with its picture.
void count(FrameUse use, const FrameVerdict& verdict, Counters* counters);

/// A reading of the scale. @return it was read.
bool count(const ScaleChange& change, Counters* counters);

/// Takes the rooms' counts: they begin anew.
void take_counts(MapCounts* map, JobCounts* jobs, Counters* counters);

}  // namespace polhode
