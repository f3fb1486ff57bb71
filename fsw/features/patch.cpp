#include "features/patch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "features/lanes.hpp"

namespace polhode::sift {
namespace {

/// Gray levels on the grid with a margin of one on each side.
template <int kSide>
using Levels = std::array<float, (kSide + 2) * (kSide + 2)>;

/// @pre 0 <= x < width - 1, 0 <= y < height - 1
float bilinear(const Plane& level, float x, float y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const float fx = x - static_cast<float>(column);
  const float fy = y - static_cast<float>(row);
  const float* above = level.row(row) + column;
  const float* below = above + level.stride;
  const float top = above[0] + fx * (above[1] - above[0]);
  const float bottom = below[0] + fx * (below[1] - below[0]);
  return top + fy * (bottom - top);
}

template <int kSide, bool kInside>
void sample(const Plane& level, const PatchFrame& frame, Levels<kSide>* out) {
  constexpr int kWide = kSide + 2;
  constexpr float kMiddle = 0.5F * (kWide - 1);
  // The last pixel has no right neighbour to interpolate with: stay a hair short of it.
  constexpr float kHair = 1e-3F;
  const float x_max = static_cast<float>(level.width - 1) - kHair;
  const float y_max = static_cast<float>(level.height - 1) - kHair;
  for (int j = 0; j < kWide; ++j) {
    const float down = static_cast<float>(j) - kMiddle;
    const float x_row = frame.x - down * frame.step_y;
    const float y_row = frame.y + down * frame.step_x;
    float* to = out->data() + j * kWide;
    for (int i = 0; i < kWide; ++i) {
      const float along = static_cast<float>(i) - kMiddle;
      float x = x_row + along * frame.step_x;
      float y = y_row + along * frame.step_y;
      if constexpr (!kInside) {
        x = std::clamp(x, 0.0F, x_max);
        y = std::clamp(y, 0.0F, y_max);
      }
      to[i] = bilinear(level, x, y);
    }
  }
}

template <class Lanes>
Lanes choose(LaneMask<Lanes> mask, Lanes yes, Lanes no) {
  return mask ? yes : no;
}

/// Direction of (x, y) in 0 .. 2 pi, to 1e-5 rad: a minimax polynomial for the eighth turn
/// (Abramowitz and Stegun, 4.4.49 shortened).
template <class Lanes>
Lanes direction_rad(Lanes x, Lanes y) {
  constexpr float kPi = std::numbers::pi_v<float>;
  const Lanes zero{};
  const Lanes ax = larger(x, -x);
  const Lanes ay = larger(y, -y);
  const Lanes t = smaller(ax, ay) / larger(larger(ax, ay), splat<Lanes>(1e-20F));
  const Lanes t2 = t * t;
  Lanes angle = t * (0.9998660F +
                     t2 * (-0.3302995F + t2 * (0.1801410F + t2 * (-0.0851330F + t2 * 0.0208351F))));
  angle = choose<Lanes>(ay > ax, 0.5F * kPi - angle, angle);
  angle = choose<Lanes>(x < zero, kPi - angle, angle);
  return choose<Lanes>(y < zero, 2.0F * kPi - angle, angle);
}

template <class Lanes, int kSide>
void to_polar(const Levels<kSide>& levels, Gradients<kSide>* out) {
  static_assert(kSide % kLanes<Lanes> == 0);
  constexpr int kWide = kSide + 2;
  for (int j = 0; j < kSide; ++j) {
    const float* row = levels.data() + (j + 1) * kWide + 1;
    for (int i = 0; i < kSide; i += kLanes<Lanes>) {
      const Lanes dx = load<Lanes>(row + i + 1) - load<Lanes>(row + i - 1);
      const Lanes dy = load<Lanes>(row + i + kWide) - load<Lanes>(row + i - kWide);
      store(square_root(dx * dx + dy * dy), out->length.data() + j * kSide + i);
      store(direction_rad(dx, dy), out->angle_rad.data() + j * kSide + i);
    }
  }
}

}  // namespace

template <int kSide>
void sample_gradients(const Plane& level, const PatchFrame& frame, Gradients<kSide>* out) {
  constexpr float kReach = 0.5F * (kSide + 1);
  const float reach = kReach * (std::abs(frame.step_x) + std::abs(frame.step_y)) + 1.0F;
  const bool inside = frame.x >= reach && frame.y >= reach &&
                      frame.x + reach < static_cast<float>(level.width - 1) &&
                      frame.y + reach < static_cast<float>(level.height - 1);
  Levels<kSide> levels;
  if (inside) {
    sample<kSide, true>(level, frame, &levels);
  } else {
    sample<kSide, false>(level, frame, &levels);
  }
  with_lanes([&](auto kind) {
    using Lanes = typename decltype(kind)::Lanes;
    to_polar<std::conditional_t<kSide % kLanes<Lanes> == 0, Lanes, Lanes4>>(levels, out);
  });
}

template void sample_gradients<12>(const Plane&, const PatchFrame&, Gradients<12>*);
template void sample_gradients<16>(const Plane&, const PatchFrame&, Gradients<16>*);

}  // namespace polhode::sift
