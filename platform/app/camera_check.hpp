// What the images say of the stated camera, for people.
#pragma once

#include <string>
#include <vector>

#include "solve/camera_verdict.hpp"

namespace polhode::platform {

/// What the stated camera was found to be at the end, and the test that says so.
struct CameraReport {
  CameraFinding found;
  CameraFit fit;
};

/// One sentence on each contradicted statement.
std::vector<std::string> camera_sentences(const CameraFinding& found, const CameraModel& camera);

}  // namespace polhode::platform
