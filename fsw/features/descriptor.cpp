#include "features/descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "features/lanes.hpp"
#include "features/patch.hpp"

namespace polhode::sift {
namespace {

// Lowe, section 6.1: 4 x 4 fields of 8 directions, weighted by a Gaussian of half their width.
constexpr int kFields = 4;
constexpr int kDirections = 8;
constexpr float kWindow = 0.5F * kFields;  // sigma, fields
// Side of a field in the blob's sigma, as OpenCV's SIFT.
constexpr float kFieldSide = 3.0F;
// Fields that the patch spans: half a field more on either side, for interpolation.
constexpr float kSpan = kFields + 1.0F;
// Samples along a side of the patch: one for each 0.94 sigma (decision 0021).
constexpr int kSide = 16;

static_assert(sizeof(Descriptor) == kFields * kFields * kDirections);

/// Interpolation weights of a row (or column) of samples in two neighbouring rows (columns) of
/// fields. The first is field - 1, as there is one extra field on either side.
struct Share {
  std::size_t field = 0;
  float first = 0.0F;
  float second = 0.0F;
};
using Shares = std::array<Share, kSide>;

Shares make_shares() {
  Shares shares{};
  for (int i = 0; i < kSide; ++i) {
    const double off = (i - 0.5 * (kSide - 1)) * static_cast<double>(kSpan) / kSide;  // fields
    const double window = std::exp(-0.5 * off * off / static_cast<double>(kWindow * kWindow));
    const double at = off + 0.5 * (kFields + 1);
    const double field = std::floor(at);
    shares[static_cast<std::size_t>(i)] = {
        .field = static_cast<std::size_t>(field),
        .first = static_cast<float>(window * (1.0 - (at - field))),
        .second = static_cast<float>(window * (at - field))};
  }
  return shares;
}

constexpr std::size_t kWide = kFields + 2;  // with the extra fields

/// The directions of a field.
struct Histogram {
  std::array<std::array<std::array<float, kDirections>, kWide>, kWide> field{};
};

/// Linear interpolation weights of the directions k, cyclic, for a gradient of direction `at` (0 ..
/// 8).
template <class Lanes>
Lanes direction_shares(Lanes k, float at) {
  const Lanes none{};
  const Lanes off = splat<Lanes>(at) - k;
  const Lanes apart = larger(off, -off);
  return larger(none, splat<Lanes>(1.0F) - smaller(apart, splat<Lanes>(kDirections) - apart));
}

template <class Lanes>
void add(float share, Lanes what, float* to) {
  store(load<Lanes>(to) + splat<Lanes>(share) * what, to);
}

/// A group of directions, one a lane, from `first` on.
template <class Lanes>
void accumulate(const Gradients<kSide>& gradients,
                const Shares& shares,
                std::size_t first,
                Histogram* histogram) {
  constexpr float kPerRad =
      0.5F * kDirections / std::numbers::pi_v<float>;  // directions per radian
  // Numbers of the directions.
  constexpr std::array<float, kDirections> kNumbers{0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};
  const Lanes directions = load<Lanes>(kNumbers.data() + first);
  for (std::size_t j = 0; j < kSide; ++j) {
    std::array<Lanes, kWide> row{};
    for (std::size_t i = 0; i < kSide; ++i) {
      const float at = gradients.angle_rad[j * kSide + i] * kPerRad;
      const Lanes part =
          splat<Lanes>(gradients.length[j * kSide + i]) * direction_shares(directions, at);
      row[shares[i].field] += splat<Lanes>(shares[i].first) * part;
      row[shares[i].field + 1] += splat<Lanes>(shares[i].second) * part;
    }
    for (std::size_t f = 1; f <= kFields; ++f) {
      add(shares[j].first, row[f], histogram->field[shares[j].field][f].data() + first);
      add(shares[j].second, row[f], histogram->field[shares[j].field + 1][f].data() + first);
    }
  }
}

Descriptor to_bytes(const Histogram& histogram) {
  constexpr std::size_t kCount = sizeof(Descriptor);
  std::array<float, kCount> value{};
  constexpr std::size_t kRow = kFields * kDirections;
  for (std::size_t r = 0; r < kFields; ++r) {
    std::memcpy(value.data() + r * kRow, histogram.field[r + 1][1].data(), kRow * sizeof(float));
  }
  float sum2 = 0.0F;
  for (const float v : value) {
    sum2 += v * v;
  }
  // Bound on an element, so that one strong edge or glint does not outweigh the rest. Lowe's value.
  constexpr float kLargest = 0.2F;
  const float limit = kLargest * std::sqrt(sum2);
  float sum = 0.0F;
  for (float& v : value) {
    v = std::min(v, limit);
    sum += v;
  }
  const float inverse = sum > 0.0F ? 1.0F / sum : 0.0F;
  Descriptor d;
  for (std::size_t i = 0; i < kCount; ++i) {
    d[i] = static_cast<std::uint8_t>(
        std::min(255.0F, kDescriptorNorm * std::sqrt(value[i] * inverse) + 0.5F));
  }
  return d;
}

}  // namespace

Descriptor compute_descriptor(const Plane& level, const OrientedPlace& place) {
  static const Shares kShares = make_shares();
  const Shares& shares = kShares;
  const float step = kSpan * kFieldSide / kSide * place.sigma_px;
  Gradients<kSide> gradients;
  sample_gradients(level,
                   {.x = place.x,
                    .y = place.y,
                    .step_x = step * std::cos(place.angle_rad),
                    .step_y = step * std::sin(place.angle_rad)},
                   &gradients);
  Histogram histogram{};
  with_lanes([&](auto kind) {
    using Lanes = typename decltype(kind)::Lanes;
    for (std::size_t first = 0; first < kDirections; first += kLanes<Lanes>) {
      accumulate<Lanes>(gradients, shares, first, &histogram);
    }
  });
  return to_bytes(histogram);
}

}  // namespace polhode::sift
