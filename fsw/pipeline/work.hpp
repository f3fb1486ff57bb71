// What jobs do: pure functions of their snapshots. run_job() and skip_job() of the public header
// stand beside them.
#pragma once

#include "pipeline/job_types.hpp"

namespace polhode {

/// The rounds of an adjustment; then, where asked for, the joint fit of motion and map.
void run_adjustment(AdjustmentJob* job);

}  // namespace polhode
