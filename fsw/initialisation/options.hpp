#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct StartOptions {
  int frames_min = 5;                 ///< frames collected before the first contest, 3 .. limits::kStartFrames
  double chi2_gap_commit = 25.0;      ///< depth-reversed twin must be worse by this (5 sigma), 9 .. 1000
  double chi2_gap_convexity = 12.0;   ///< enough where the convexity cue agrees, 4 .. chi2_gap_commit
};

}  // namespace polhode
