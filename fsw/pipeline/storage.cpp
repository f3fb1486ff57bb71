#include "pipeline/storage.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace polhode {

MemoryNeed memory_needed(const Parameters& /*parameters*/) {
  using State = Component::State;
  static constexpr TableNeed kTables[] = {
      {"keyframes", sizeof(Map::keyframes)},
      {"landmarks", sizeof(Map::landmarks)},
      {"frames and tracks before the map", sizeof(State::initialisation)},
      {"job: start of a map", sizeof(MapJob::start)},
      {"job: adjustment", sizeof(MapJob::adjustment)},
      {"job: fit of the dynamics", sizeof(FitJob)},
      {"job: shape", sizeof(ShapeJob)},
      {"poses so far", sizeof(State::motion)},
      {"features of the frame", sizeof(State::features)},
      {"reference of optical flow", sizeof(State::reference)},
      {"matches of the frame and of a closure", sizeof(State::localised) + sizeof(State::closure)},
      {"working memory of detection", sizeof(State::feature_workspace)},
      {"working memory of matching",
       sizeof(State::localise_scratch) + sizeof(State::create_scratch)},
      {"observations put out", sizeof(State::observations)},
  };
  static constexpr std::size_t kListed = [] {
    std::size_t sum = 0;
    for (const TableNeed& table : kTables) {
      sum += table.octets;
    }
    return sum;
  }();
  static constexpr TableNeed kRest{"everything else", sizeof(Storage) - kListed};
  static constexpr auto kAll = [] {
    std::array<TableNeed, std::size(kTables) + 1> all;
    std::copy(std::begin(kTables), std::end(kTables), all.begin());
    all.back() = kRest;
    return all;
  }();
  return {.total = sizeof(Storage), .tables = kAll};
}

}  // namespace polhode
