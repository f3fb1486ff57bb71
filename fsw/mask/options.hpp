#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct MaskOptions {
  bool enabled = true;       ///< separate the target from empty space; false: the whole image is the target
  bool background = true;    ///< separate the target from a lit background, too; needs `enabled`
  // 7 of 255 gray levels. Chosen, above image.dark_level; larger loses dim parts of the target.
  double dark_level = 0.03;  ///< pixels at or below this fraction of full scale are empty space

  [[nodiscard]] bool separates_background() const { return enabled && background; }
};

}  // namespace polhode
