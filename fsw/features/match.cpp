#include "features/match.hpp"

#include <algorithm>

#include "base/avx2_dispatch.hpp"

namespace polhode {
namespace {

// Distance within which features are orientations of one blob. Chosen: their places are equal,
// those of other blobs seldom as close.
constexpr float kSamePlace_px = 1.0F;

using Bests = std::array<NearestFeature, limits::kFeatures>;

/// Nearest feature of the other list for each, and the nearest at another place.
void find_nearest(std::span<const Feature> a,
                  std::span<const Feature> b,
                  Bests* forward,
                  Bests* back) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int d2 = distance2(a[i].descriptor, b[j].descriptor);
      keep_nearest(static_cast<std::int32_t>(j), d2, b, kSamePlace_px, &(*forward)[i]);
      keep_nearest(static_cast<std::int32_t>(i), d2, a, kSamePlace_px, &(*back)[j]);
    }
  }
}

}  // namespace

int FeatureGrid::cell_of(double position_px, double size_px) const {
  return std::clamp(static_cast<int>(position_px * kCells / size_px), 0, kCells - 1);
}

void FeatureGrid::build(std::span<const Feature> features, int width_px, int height_px) {
  POLHODE_ASSERT(features.size() <= places_.size(), features.size());
  width_px_ = width_px;
  height_px_ = height_px;
  first_.fill(0);
  const auto cell = [&](const Feature& f) {
    return static_cast<std::size_t>(cell_of(static_cast<double>(f.v_px), height_px_) * kCells +
                                    cell_of(static_cast<double>(f.u_px), width_px_));
  };
  for (const Feature& f : features) {
    ++first_[cell(f) + 1];
  }
  for (std::size_t c = 1; c < first_.size(); ++c) {
    first_[c] += first_[c - 1];
  }
  std::array<std::int32_t, kCells* kCells + 1> next = first_;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Feature& f = features[i];
    places_[static_cast<std::size_t>(next[cell(f)]++)] = {
        .u_px = f.u_px, .v_px = f.v_px, .feature = static_cast<std::int32_t>(i)};
  }
}

std::size_t FeatureGrid::find(double u_px,
                              double v_px,
                              double radius_px,
                              std::span<std::int32_t> out) const {
  std::size_t found = 0;
  const int row_last = cell_of(v_px + radius_px, height_px_);
  const int column_first = cell_of(u_px - radius_px, width_px_);
  const int column_last = cell_of(u_px + radius_px, width_px_);
  for (int row = cell_of(v_px - radius_px, height_px_); row <= row_last; ++row) {
    const auto begin =
        static_cast<std::size_t>(first_[static_cast<std::size_t>(row * kCells + column_first)]);
    const auto end =
        static_cast<std::size_t>(first_[static_cast<std::size_t>(row * kCells + column_last + 1)]);
    for (std::size_t k = begin; k < end && found < out.size(); ++k) {
      const double du = static_cast<double>(places_[k].u_px) - u_px;
      const double dv = static_cast<double>(places_[k].v_px) - v_px;
      if (du * du + dv * dv <= radius_px * radius_px) {
        out[found++] = places_[k].feature;
      }
    }
  }
  return found;
}

void match_mutual(std::span<const Feature> a,
                  std::span<const Feature> b,
                  double ratio_max,
                  FeatureMatches* matches) {
  matches->clear();
  if (a.empty() || b.empty()) {
    return;
  }
  POLHODE_ASSERT(a.size() <= limits::kFeatures && b.size() <= limits::kFeatures, a.size());
  Bests forward;
  Bests back;
  with_avx2([&] { find_nearest(a, b, &forward, &back); });
  const double ratio2 = ratio_max * ratio_max;
  const auto stands_out = [&](const NearestFeature& best) {
    return best.nearest2 <= ratio2 * best.rival2;
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto j = static_cast<std::size_t>(forward[i].feature);
    if (forward[i].nearest2 > kDistance2Max || !stands_out(forward[i]) || !stands_out(back[j])) {
      continue;
    }
    if (same_place(a[static_cast<std::size_t>(back[j].feature)], a[i], kSamePlace_px)) {
      (void)matches->push_back({.a = static_cast<std::int32_t>(i),
                                .b = forward[i].feature,
                                .distance2 = forward[i].nearest2});
    }
  }
}

}  // namespace polhode
