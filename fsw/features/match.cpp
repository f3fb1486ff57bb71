#include "features/match.hpp"

#include <algorithm>
#include <limits>

namespace polhode {
namespace {

bool same_place(const Feature& a, const Feature& b) {
  // A feature with two orientations stands twice at one place: its twin is no rival.
  constexpr float kSamePlace_px = 1.0F;
  const float du = a.u_px - b.u_px;
  const float dv = a.v_px - b.v_px;
  return du * du + dv * dv < kSamePlace_px * kSamePlace_px;
}

struct Best {
  std::int32_t index = -1;
  int nearest2 = std::numeric_limits<int>::max();
  int rival2 = std::numeric_limits<int>::max();
};

Best best_of(const Feature& wanted, std::span<const Feature> among) {
  Best best;
  for (std::size_t j = 0; j < among.size(); ++j) {
    const int d2 = distance2(wanted.descriptor, among[j].descriptor);
    if (d2 < best.nearest2) {
      if (best.index >= 0 && !same_place(among[j], among[static_cast<std::size_t>(best.index)])) {
        best.rival2 = best.nearest2;
      }
      best.nearest2 = d2;
      best.index = static_cast<std::int32_t>(j);
    } else if (d2 < best.rival2 &&
               !same_place(among[j], among[static_cast<std::size_t>(best.index)])) {
      best.rival2 = d2;
    }
  }
  return best;
}

}  // namespace

int distance2(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int difference = static_cast<int>(a[i]) - static_cast<int>(b[i]);
    sum += difference * difference;
  }
  return sum;
}

int FeatureGrid::cell_of(double position_px, double size_px) const {
  return std::clamp(static_cast<int>(position_px * kCells / size_px), 0, kCells - 1);
}

void FeatureGrid::build(std::span<const Feature> features, int width_px, int height_px) {
  POLHODE_ASSERT(features.size() <= order_.size(), features.size());
  width_px_ = width_px;
  height_px_ = height_px;
  first_.fill(0);
  const auto cell = [&](const Feature& f) {
    return static_cast<std::size_t>(cell_of(f.v_px, height_px_) * kCells +
                                    cell_of(f.u_px, width_px_));
  };
  for (const Feature& f : features) {
    ++first_[cell(f) + 1];
  }
  for (std::size_t c = 1; c < first_.size(); ++c) {
    first_[c] += first_[c - 1];
  }
  std::array<std::int32_t, kCells* kCells + 1> next = first_;
  for (std::size_t i = 0; i < features.size(); ++i) {
    order_[static_cast<std::size_t>(next[cell(features[i])]++)] = static_cast<std::int32_t>(i);
  }
}

std::size_t FeatureGrid::find(std::span<const Feature> features,
                              double u_px,
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
      const Feature& f = features[static_cast<std::size_t>(order_[k])];
      const double du = static_cast<double>(f.u_px) - u_px;
      const double dv = static_cast<double>(f.v_px) - v_px;
      if (du * du + dv * dv <= radius_px * radius_px) {
        out[found++] = order_[k];
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
  const double ratio2 = ratio_max * ratio_max;
  for (std::size_t i = 0; i < a.size() && !matches->full(); ++i) {
    const Best forward = best_of(a[i], b);
    if (forward.nearest2 > kDistance2Max || forward.nearest2 > ratio2 * forward.rival2) {
      continue;
    }
    const Best back = best_of(b[static_cast<std::size_t>(forward.index)], a);
    const bool mutual =
        back.index >= 0 && same_place(a[static_cast<std::size_t>(back.index)], a[i]);
    if (mutual && back.nearest2 <= ratio2 * back.rival2) {
      (void)matches->push_back(
          {.a = static_cast<std::int32_t>(i), .b = forward.index, .distance2 = forward.nearest2});
    }
  }
}

}  // namespace polhode
