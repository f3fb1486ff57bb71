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
      {"job: start of a map", sizeof(JobQueue::start)},
      {"job: adjustment", sizeof(JobQueue::adjustment)},
      {"job: fit of the dynamics", sizeof(FitJob)},
      {"job: shape", sizeof(ShapeJob)},
      {"job: test of the camera", sizeof(CameraJob)},
      {"poses so far", sizeof(State::motion)},
      {"features of the frame", sizeof(FeatureState::features)},
      {"reference of optical flow", sizeof(MapState::reference)},
      {"matches of the frame and of a closure",
       sizeof(MapState::localised) + sizeof(MapScratch::other)},
      {"working memory of detection", sizeof(FeatureState::workspace)},
      {"working memory of matching", sizeof(MapScratch::localise) + sizeof(MapScratch::create)},
      {"observations put out", sizeof(Answer::observations)},
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
