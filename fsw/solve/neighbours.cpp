#include "solve/neighbours.hpp"

#include <flann/flann.hpp>
#include <vector>

#include "base/assert.hpp"

namespace polhode {

void nearest_descriptors(std::span<const std::uint8_t> reference,
                         std::span<const std::uint8_t> queries,
                         std::span<Neighbours> out) {
  constexpr auto kColumns = static_cast<std::size_t>(kDescriptorOctets);
  POLHODE_ASSERT(reference.size() % kColumns == 0, reference.size());
  POLHODE_ASSERT(queries.size() == out.size() * kColumns, queries.size());
  const std::size_t rows = reference.size() / kColumns;
  if (rows == 0 || out.empty()) {
    return;
  }
  std::vector<unsigned char> data(reference.begin(), reference.end());
  std::vector<unsigned char> wanted(queries.begin(), queries.end());
  const flann::Matrix<unsigned char> table(data.data(), rows, kColumns);
  const flann::Matrix<unsigned char> query(wanted.data(), out.size(), kColumns);
  // Exhaustive: FLANN 1.9.2 shuffles the points of its randomised trees by std::random_device,
  // which no seed reaches.
  flann::Index<flann::L2<unsigned char>> index(table, flann::LinearIndexParams());
  index.buildIndex();
  const std::size_t k = rows > 1 ? 2 : 1;
  std::vector<int> ids(out.size() * k, -1);
  std::vector<float> distances(out.size() * k, 0.0F);
  flann::Matrix<int> id_rows(ids.data(), out.size(), k);
  flann::Matrix<float> distance_rows(distances.data(), out.size(), k);
  flann::SearchParams search;
  search.cores = 1;
  index.knnSearch(query, id_rows, distance_rows, k, search);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].nearest = ids[i * k];
    out[i].distance2_nearest = distances[i * k];
    out[i].second = k > 1 ? ids[i * k + 1] : -1;
    out[i].distance2_second = k > 1 ? distances[i * k + 1] : 0.0F;
  }
}

}  // namespace polhode
