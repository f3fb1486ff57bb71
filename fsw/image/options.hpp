#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct ImageOptions {
  double dark_level = 0.02;        ///< a frame whose brightest 0.1 % lie under this fraction of full scale is dark, 0 .. 0.5
  double saturated_level = 0.98;   ///< pixels at or over this fraction of full scale are saturated, 0.5 .. 1
};

}  // namespace polhode
