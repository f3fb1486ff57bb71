// Nearest descriptors, for relocalisation against the entire map.
#pragma once

#include <cstdint>
#include <span>

namespace polhode {

/// Size of a SIFT descriptor: 4 x 4 fields of 8 directions, a byte each.
inline constexpr int kDescriptorBytes = 128;

struct Neighbours {
  std::int32_t nearest = -1;
  std::int32_t second = -1;
  float distance2_nearest = 0.0F;
  float distance2_second = 0.0F;
};

/// For each query the two nearest of the reference descriptors (rows of 128 bytes, Euclidean),
/// exactly.
/// @param out  one per query; `second` is -1 where there is just one reference.
/// @cost  rows times queries distances: the caller bounds both. Deterministic.
void nearest_descriptors(std::span<const std::uint8_t> reference,
                         std::span<const std::uint8_t> queries,
                         std::span<Neighbours> out);

}  // namespace polhode
