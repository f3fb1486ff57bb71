// Result of the test of the stated camera, as text and JSON.
#pragma once

#include <string>
#include <vector>

#include "solve/camera_verdict.hpp"

namespace polhode::platform {

/// Result of the camera test at the end, and the test itself.
struct CameraReport {
  CameraFinding found;
  CameraFit fit;
};

/// One sentence on each contradicted statement.
std::vector<std::string> camera_sentences(const CameraFinding& found, const CameraModel& camera);

}  // namespace polhode::platform
