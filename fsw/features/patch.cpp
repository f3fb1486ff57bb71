#include "features/patch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <type_traits>

#include "features/lanes.hpp"

namespace polhode::sift {
namespace {

/// Samples along a side of the grid with its margin of one, rounded up to whole groups of lanes.
template <int kSide>
inline constexpr int kRow = stride_of(kSide + 2);

/// Gray levels on the grid with its margin. Columns from kSide + 2 on are padding.
template <int kSide>
using Levels = std::array<float, (kSide + 2) * kRow<kSide>>;

/// Position of each sample of a row: the pixel up and left of it, and the fractions beyond.
template <int kSide>
struct RowPlaces {
  std::array<std::int32_t, kRow<kSide>> offset;  ///< floats from the image's first
  std::array<float, kRow<kSide>> right;
  std::array<float, kRow<kSide>> down;
};

/// The four pixels around each sample of a row: those above it and those below it. In each list
/// the left and the right one of a sample follow each other.
template <int kSide>
struct RowPixels {
  std::array<float, 2 * kRow<kSide>> above;
  std::array<float, 2 * kRow<kSide>> below;
};

template <class Lanes>
using WholeLanes = LaneMask<Lanes>;  // integers of 32 bits

template <class Lanes, int kSide, bool kInside>
void place_row(const Plane& level, const PatchFrame& frame, int j, RowPlaces<kSide>* out) {
  // Index of the centre: with a margin of one the samples of a row or column are 0 .. kSide + 1.
  constexpr float kMiddle = 0.5F * (kSide + 1);
  // The last pixel has no right neighbour to interpolate with: stay short of it, by more than the
  // spacing of floats at limits::kWorkingSide (2.4e-4).
  constexpr float kHair = 1e-3F;
  const float down = static_cast<float>(j) - kMiddle;
  const Lanes x_row = splat<Lanes>(frame.x - down * frame.step_y);
  const Lanes y_row = splat<Lanes>(frame.y + down * frame.step_x);
  // Numbers of the lanes.
  constexpr std::array<float, kRowGrain> kNumbers{0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};
  for (int i = 0; i < kRow<kSide>; i += kLanes<Lanes>) {
    const Lanes along = load<Lanes>(kNumbers.data() + i % kRowGrain) +
                        (static_cast<float>(i - i % kRowGrain) - kMiddle);
    Lanes x = x_row + along * splat<Lanes>(frame.step_x);
    Lanes y = y_row + along * splat<Lanes>(frame.step_y);
    if constexpr (!kInside) {
      const Lanes zero{};
      x = smaller(larger(x, zero), splat<Lanes>(static_cast<float>(level.width - 1) - kHair));
      y = smaller(larger(y, zero), splat<Lanes>(static_cast<float>(level.height - 1) - kHair));
    }
    const auto column = __builtin_convertvector(x, WholeLanes<Lanes>);
    const auto row = __builtin_convertvector(y, WholeLanes<Lanes>);
    const auto offset = row * level.stride + column;
    std::memcpy(out->offset.data() + i, &offset, sizeof offset);
    store(x - __builtin_convertvector(column, Lanes), out->right.data() + i);
    store(y - __builtin_convertvector(row, Lanes), out->down.data() + i);
  }
}

template <int kSide>
void fetch_row(const Plane& level, const RowPlaces<kSide>& places, RowPixels<kSide>* out) {
  for (std::size_t i = 0; i < kSide + 2; ++i) {
    const float* from = level.data + places.offset[i];
    std::memcpy(out->above.data() + 2 * i, from, 2 * sizeof(float));
    std::memcpy(out->below.data() + 2 * i, from + level.stride, 2 * sizeof(float));
  }
}

template <class Lanes>
struct Pair {
  Lanes left;
  Lanes right;
};

/// Separates left and right pixels of the samples of one group of lanes.
template <class Lanes>
Pair<Lanes> apart(const float* from) {
  const Lanes low = load<Lanes>(from);
  const Lanes high = load<Lanes>(from + kLanes<Lanes>);
  if constexpr (kLanes<Lanes> == 8) {
    return {.left = __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14),
            .right = __builtin_shufflevector(low, high, 1, 3, 5, 7, 9, 11, 13, 15)};
  } else {
    return {.left = __builtin_shufflevector(low, high, 0, 2, 4, 6),
            .right = __builtin_shufflevector(low, high, 1, 3, 5, 7)};
  }
}

/// Bilinear interpolation.
template <class Lanes, int kSide>
void interpolate_row(const RowPlaces<kSide>& places, const RowPixels<kSide>& pixels, float* out) {
  for (int i = 0; i < kRow<kSide>; i += kLanes<Lanes>) {
    const Lanes right = load<Lanes>(places.right.data() + i);
    const auto between = [&](const float* from) {
      const Pair<Lanes> pair = apart<Lanes>(from);
      return pair.left + right * (pair.right - pair.left);
    };
    const Lanes top = between(pixels.above.data() + 2 * i);
    const Lanes bottom = between(pixels.below.data() + 2 * i);
    store(top + load<Lanes>(places.down.data() + i) * (bottom - top), out + i);
  }
}

template <class Lanes, int kSide, bool kInside>
void sample(const Plane& level, const PatchFrame& frame, Levels<kSide>* out) {
  RowPlaces<kSide> places;
  RowPixels<kSide> pixels{};
  for (int j = 0; j < kSide + 2; ++j) {
    place_row<Lanes, kSide, kInside>(level, frame, j, &places);
    fetch_row<kSide>(level, places, &pixels);
    interpolate_row<Lanes, kSide>(places, pixels, out->data() + j * kRow<kSide>);
  }
}

template <class Lanes>
Lanes choose(LaneMask<Lanes> mask, Lanes yes, Lanes no) {
  return mask ? yes : no;
}

/// Direction of (x, y) in 0 .. 2 pi, to 1e-5 rad: a minimax polynomial for the first octant
/// (Abramowitz and Stegun, 4.4.49 shortened).
template <class Lanes>
Lanes direction_rad(Lanes x, Lanes y) {
  constexpr float kPi = std::numbers::pi_v<float>;
  const Lanes zero{};
  const Lanes ax = larger(x, -x);
  const Lanes ay = larger(y, -y);
  constexpr float kNotZero = 1e-20F;  // gives 0 for the direction of (0, 0)
  const Lanes t = smaller(ax, ay) / larger(larger(ax, ay), splat<Lanes>(kNotZero));
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
  for (int j = 0; j < kSide; ++j) {
    const float* row = levels.data() + (j + 1) * kRow<kSide> + 1;
    for (int i = 0; i < kSide; i += kLanes<Lanes>) {
      const Lanes dx = load<Lanes>(row + i + 1) - load<Lanes>(row + i - 1);
      const Lanes dy = load<Lanes>(row + i + kRow<kSide>) - load<Lanes>(row + i - kRow<kSide>);
      store(square_root(dx * dx + dy * dy), out->length.data() + j * kSide + i);
      store(direction_rad(dx, dy), out->angle_rad.data() + j * kSide + i);
    }
  }
}

}  // namespace

template <int kSide>
void sample_gradients(const Plane& level, const PatchFrame& frame, Gradients<kSide>* out) {
  // Steps from the centre to the outermost samples, in the margin of one.
  constexpr float kReach = 0.5F * (kSide + 1);
  const float reach = kReach * (std::abs(frame.step_x) + std::abs(frame.step_y)) + 1.0F;
  const bool inside = frame.x >= reach && frame.y >= reach &&
                      frame.x + reach < static_cast<float>(level.width - 1) &&
                      frame.y + reach < static_cast<float>(level.height - 1);
  Levels<kSide> levels;
  with_lanes([&](auto kind) {
    using Lanes = typename decltype(kind)::Lanes;
    if (inside) {
      sample<Lanes, kSide, true>(level, frame, &levels);
    } else {
      sample<Lanes, kSide, false>(level, frame, &levels);
    }
    to_polar<std::conditional_t<kSide % kLanes<Lanes> == 0, Lanes, Lanes4>>(levels, out);
  });
}

template void sample_gradients<12>(const Plane&, const PatchFrame&, Gradients<12>*);
template void sample_gradients<16>(const Plane&, const PatchFrame&, Gradients<16>*);

}  // namespace polhode::sift
