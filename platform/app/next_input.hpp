// What a step is given: the frame, the job that is due, and whether memory ran short.
#pragma once

#include "os/linux/worker.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// Waits for a job that is due and not done.
StepInput next_input(const Component& component, Worker& worker, const Frame& frame);

}  // namespace polhode::platform
