#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct MaskOptions {
  bool enabled = true;
  double dark_level = 0.03;  ///< pixels at or under this fraction of full scale count as empty space, 0 .. 0.5
};

}  // namespace polhode
