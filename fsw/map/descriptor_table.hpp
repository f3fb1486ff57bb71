// Descriptors of landmarks from all their views, for a search by appearance alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "features/detect.hpp"
#include "map/map.hpp"
#include "solve/neighbours.hpp"

namespace polhode {

/// One row for each view of a landmark.
struct DescriptorTable {
  std::vector<std::uint8_t> octets;
  std::vector<std::int32_t> landmark;  ///< slot
  std::vector<std::int32_t> view;      ///< index into its views
};

/// Views of the selected landmarks, at most kRowsMax: of more, only every second or third landmark
/// is taken.
/// @param turn  number of the call; each takes other landmarks.
template <typename TakesPart>
DescriptorTable views_of(const Map& map, std::size_t turn, const TakesPart& takes_part) {
  constexpr std::size_t kRowsMax = 4000;  // 600 x 3200 distances take 7 ms
  std::size_t rows = 0;
  for (const Landmark& landmark : map.landmarks) {
    rows += landmark.used && takes_part(landmark) ? landmark.views.size() : 0;
  }
  const std::size_t stride = rows / kRowsMax + 1;
  DescriptorTable table;
  std::size_t counted = turn % stride;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (!map.landmarks[i].used || !takes_part(map.landmarks[i]) || counted++ % stride != 0) {
      continue;
    }
    for (std::size_t v = 0; v < map.landmarks[i].views.size(); ++v) {
      const Descriptor& descriptor = map.landmarks[i].views[v].descriptor;
      table.octets.insert(table.octets.end(), descriptor.begin(), descriptor.end());
      table.landmark.push_back(static_cast<std::int32_t>(i));
      table.view.push_back(static_cast<std::int32_t>(v));
    }
  }
  return table;
}

/// The two rows nearest to each feature's descriptor.
inline std::vector<Neighbours> nearest_rows(const DescriptorTable& table,
                                            const Features& features) {
  std::vector<std::uint8_t> queries;
  for (const Feature& feature : features) {
    queries.insert(queries.end(), feature.descriptor.begin(), feature.descriptor.end());
  }
  std::vector<Neighbours> found(features.size());
  nearest_descriptors(table.octets, queries, found);
  return found;
}

}  // namespace polhode
