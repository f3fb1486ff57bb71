// Where a run stands, on standard error: one living line on a terminal, a plain line every few
// seconds elsewhere.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "motion/motion_state.hpp"

namespace polhode::platform {

class Progress {
 public:
  explicit Progress(std::size_t frames);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::size_t frames_done, const MotionState& motion);
  void note(const std::string& line);  ///< one line that stays

 private:
  void wipe();

  std::size_t frames_;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace polhode::platform
