// Are a camera's numbers those of a lens and of these images?
#pragma once

#include <string>
#include <vector>

#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// Warnings, one line each, without a file's name: a principal point far from the middle, an
/// unusual focal length, pixels that are no squares, a distortion that folds back.
/// @param pixel_aspect  width over height of a pixel's field of view
std::vector<std::string> lens_warnings(const CameraParameters& camera, double pixel_aspect = 1.0);

/// Numbers that make no camera as they stand and a usual one in another order.
/// @return one line without a file's name; empty where they are in order.
std::string wrong_order(const CameraParameters& camera);

}  // namespace polhode::platform
