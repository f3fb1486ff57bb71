#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct MaskOptions {
  bool enabled = true;
  bool background = true;    ///< tell the target from what is behind it, where something is
  double dark_level = 0.03;  ///< pixels at or under this fraction of full scale count as empty space, 0 .. 0.5

  [[nodiscard]] bool tells_background() const { return enabled && background; }
};

}  // namespace polhode
