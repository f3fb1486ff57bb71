#include "app/next_input.hpp"

#include "os/linux/memory/region.hpp"

namespace polhode::platform {

StepInput next_input(const Component& component, Worker& worker, const Frame& frame) {
  const Jobs finished = worker.due(component.next_step());
  bool memory_short = false;
  for (const Pool pool : {Pool::kGeneral, Pool::kStep, Pool::kJobs}) {
    memory_short = take_overdrafts(pool) > 0 || memory_short;
  }
  return {.frame = frame, .finished = finished, .memory_short = memory_short};
}

}  // namespace polhode::platform
