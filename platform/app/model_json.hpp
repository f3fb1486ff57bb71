// motion_model.json: how the target moves, in numbers that outlast the run.
#pragma once

#include <filesystem>
#include <span>

#include "motion/trajectory.hpp"

namespace polhode::platform {

/// Fits the motion model to the run's poses and writes it; what the data do not determine is null,
/// with its reason.
/// @param body_radius  half the body's largest dimension, unit of the poses.
void write_model_json(const std::filesystem::path& file,
                      std::span<const PoseSample> samples,
                      double body_radius,
                      bool scale_known);

}  // namespace polhode::platform
