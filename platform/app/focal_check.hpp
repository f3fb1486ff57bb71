// Do the pictures bear the given focal length out?
#pragma once

#include <string>

#include "pipeline/parameters.hpp"
#include "solve/focal_adjustment.hpp"

namespace polhode::platform {

/// One sentence on a refuted focal length; empty where it is not.
std::string focal_sentence(const FocalReport& found, const CameraParameters& camera);

}  // namespace polhode::platform
