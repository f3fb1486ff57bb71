#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct ImageOptions {
  // 5 of 255 gray levels. Chosen; larger takes dim frames for dark ones.
  double dark_level = 0.02;        ///< a frame is dark unless 0.1 % of its pixels, or 400, reach this fraction of full scale
  // 250 of 255 gray levels. Chosen: leaves five levels for noise about full scale.
  double saturated_level = 0.98;   ///< pixels at or above this fraction of full scale are saturated
};

}  // namespace polhode
