// motion.csv and motion_smoothed.csv: one row per input frame, an empty cell where a value is
// unknown.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "motion/motion_state.hpp"

namespace polhode::platform {

struct MotionRow {
  std::size_t frame = 0;  ///< index of the input frame
  std::int64_t timestamp_ns = 0;
  bool used = true;  ///< the frame was looked at; else nothing was counted in it
  std::optional<std::int64_t> step_us = {};
};

std::string motion_csv_header();
std::string motion_csv_row(const MotionRow& row, const MotionState& motion);

const char* mode_name(Mode mode);

}  // namespace polhode::platform
