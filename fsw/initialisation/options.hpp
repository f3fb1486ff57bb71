#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct InitialOptions {
  // decision 0028: with 4 frames 8 of 64 maps are wrong, with 5 frames 2.
  int frames_min = 5;                 ///< frames collected before the first hypothesis selection
  // 5 sigma, squared.
  double chi2_gap_commit = 25.0;      ///< cost margin (chi-square) to the best rival, such as the depth-reversed solution
  // Seven less: one dish in thirty bodies, so what convexity may add (decision 0107).
  double chi2_gap_convexity = 18.0;   ///< smaller cost margin, accepted when the convexity cue agrees
};

}  // namespace polhode
