// Memory of a run beside the estimator's: for packets, images of the device, checkpoints,
// recordings.
#pragma once

#include "camera/replay/sequence.hpp"
#include "memory_plan.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/transport_options.hpp"

namespace polhode::platform {

/// Of packets that wait for a reader, and of the image of the servicer's own.
MachineNeeds transport_needs(const TransportOptions& options, const CameraParameters& camera);

/// Adds the needs of frames from files.
void add_sequence(const Sequence& sequence, MachineNeeds* needs);

/// Of a live run.
MachineNeeds live_needs(const MachineOptions& machine,
                        const TransportOptions& options,
                        const CameraParameters& camera);

/// Bytes of a recorded image at most.
std::size_t recorded_frame_bytes(const CameraParameters& camera);

}  // namespace polhode::platform
