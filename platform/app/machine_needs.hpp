// Memory of a run beside the estimator's: for packets, pictures of the device, checkpoints, recordings.
#pragma once

#include "memory_plan.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/transport_options.hpp"

namespace polhode::platform {

/// Of packets that wait for a reader, and of the network; all that a replay needs.
MachineNeeds transport_needs(const TransportOptions& options);

/// Of a live run.
MachineNeeds live_needs(const MachineOptions& machine,
                        const TransportOptions& options,
                        const CameraParameters& camera);

/// Octets of a recorded picture at most.
std::size_t recorded_frame_octets(const CameraParameters& camera);

}  // namespace polhode::platform
