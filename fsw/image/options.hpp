#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct ImageOptions {
  double dark_level = 0.02;        ///< a frame is dark unless 0.1 % of its pixels, or 400 of them, lie over this fraction of full scale, 0 .. 0.5
  double saturated_level = 0.98;   ///< pixels at or over this fraction of full scale are saturated, 0.5 .. 1
};

}  // namespace polhode
