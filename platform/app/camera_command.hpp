// polhode camera list | probe: lists the cameras, the capabilities of one, and the mode that
// Polhode would use.
#pragma once

#include <string>

namespace polhode::platform {

/// A line for each video node.
void list_cameras();

struct ProbeArguments {
  std::string device;
  int width_px = 0;  ///< 0: as the device is set
  int height_px = 0;
};

/// @throws UnusableInput when the device cannot be queried, or has no usable format.
void probe_camera(const ProbeArguments& arguments);

}  // namespace polhode::platform
