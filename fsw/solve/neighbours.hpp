// Nearest descriptors by kd-tree, for relocalisation against everything in the map.
#pragma once

#include <cstdint>
#include <span>

namespace polhode {

inline constexpr int kDescriptorOctets = 128;

struct Neighbours {
  std::int32_t nearest = -1;
  std::int32_t second = -1;
  float distance2_nearest = 0.0F;
  float distance2_second = 0.0F;
};

/// For each query the two nearest of the reference descriptors (rows of 128 octets, Euclidean), approximately: randomised
/// kd-trees with a fixed seed and a bound on the leaves visited. The tree is built and dropped inside the call.
/// @param out  one per query; `second` is -1 where there is just one reference.
void nearest_descriptors(std::span<const std::uint8_t> reference,
                         std::span<const std::uint8_t> queries,
                         std::span<Neighbours> out);

}  // namespace polhode
