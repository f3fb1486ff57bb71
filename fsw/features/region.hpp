// Position of the working image in the camera's image.
#pragma once

#include <opencv2/core/types.hpp>

#include "features/resample.hpp"
#include "mask/target_mask.hpp"

namespace polhode::sift {

struct Region {
  const TargetMask* mask = nullptr;
  WorkingSize size;

  [[nodiscard]] double u_px(double x) const {
    return (x + 0.5) / size.factor_u - 0.5 + mask->region_px.x;
  }
  [[nodiscard]] double v_px(double y) const {
    return (y + 0.5) / size.factor_v - 0.5 + mask->region_px.y;
  }
  [[nodiscard]] bool on_target(double x, double y) const {
    return mask->contains(u_px(x), v_px(y));
  }
};

}  // namespace polhode::sift
