// *.tum: the camera's path in the target frame, as trajectory tools read it.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "motion/motion_state.hpp"

namespace polhode::platform {

/// `timestamp_s tx ty tz qx qy qz qw`: position of C in T and rotation q_TC; empty without a pose.
std::string tum_line(const MotionState& motion);

/// One line a frame with a pose.
void write_trajectory(const std::filesystem::path& file, std::span<const MotionState> motion);

/// One line for each frame whose pose is in the last pose's target frame and unit of length, so
/// that one alignment can be fitted.
void write_last_trajectory(const std::filesystem::path& file, std::span<const MotionState> motion);

}  // namespace polhode::platform
