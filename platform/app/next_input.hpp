// Input of a step: the frame, the jobs that are due, and whether memory ran short.
#pragma once

#include "os/linux/worker.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// Waits for the jobs that are due and not done.
StepInput next_input(const Component& component, Worker& worker, const Frame& frame);

}  // namespace polhode::platform
