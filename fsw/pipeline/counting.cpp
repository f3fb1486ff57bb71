#include "pipeline/counting.hpp"

#include <utility>

#include "bus/frame_uses.hpp"
#include "map/map_state.hpp"
#include "pipeline/job.hpp"
#include "shape/scale_state.hpp"

namespace polhode {

void count(FrameUse use, const FrameVerdict& verdict, Counters* counters) {
  if (const auto counter = row_of(use).counter) {
    ++(counters->*counter);
  }
  counters->frames_with_care += verdict.decision == FrameDecision::kCare ? 1 : 0;
  if (const FrameFaultRow* const fault = row_of(verdict.fault)) {
    ++(counters->*fault->counter);
  }
}

bool count(const ScaleChange& change, Counters* counters) {
  counters->scale_contradictions += change.contradiction_began ? 1 : 0;
  return change.read;
}

void take_counts(MapCounts* map, JobCounts* jobs, Counters* counters) {
  const MapCounts by_map = std::exchange(*map, {});
  const JobCounts by_jobs = std::exchange(*jobs, {});
  counters->tables_full += by_map.tables_full + by_jobs.tables_full;
  counters->keyframes_inserted += by_map.keyframes_inserted;
  counters->keyframes_culled += by_map.keyframes_culled;
  counters->landmarks_created += by_map.landmarks_created;
  counters->landmarks_culled += by_map.landmarks_culled;
  counters->closures += by_map.closures;
  counters->jobs_issued += by_jobs.issued;
}

}  // namespace polhode
