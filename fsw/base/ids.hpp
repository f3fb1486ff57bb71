// Slots of different tables are different types: a landmark's slot cannot index the keyframes.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

namespace polhode {

template <typename Tag>
struct Id {
  std::int32_t slot = -1;

  [[nodiscard]] bool valid() const { return slot >= 0; }
  [[nodiscard]] std::size_t index() const { return static_cast<std::size_t>(slot); }
  auto operator<=>(const Id&) const = default;

  static Id from_index(std::size_t index) { return Id{static_cast<std::int32_t>(index)}; }
};

using LandmarkId = Id<struct LandmarkTag>;
using KeyframeId = Id<struct KeyframeTag>;
using TrackId = Id<struct TrackTag>;
using FeatureId = Id<struct FeatureTag>;

}  // namespace polhode
