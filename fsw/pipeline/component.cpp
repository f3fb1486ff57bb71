#include "pipeline/component.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <memory>
#include <new>

#include "pipeline/parameter_image.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

constexpr std::size_t kAlignment = 64;

/// The component and its state lie side by side in the caller's memory.
struct alignas(kAlignment) Storage {
  Component::State state;
  alignas(kAlignment) std::byte component[sizeof(Component)];
};

}  // namespace

CameraModel to_model(const CameraParameters& c) {
  return {.width_px = c.width_px,
          .height_px = c.height_px,
          .fu_px = c.fu_px,
          .fv_px = c.fv_px,
          .cu_px = c.cu_px,
          .cv_px = c.cv_px,
          .k1 = c.k1,
          .k2 = c.k2,
          .p1 = c.p1,
          .p2 = c.p2};
}

MemoryNeed memory_needed(const Parameters& /*parameters*/) {
  using State = Component::State;
  static constexpr TableNeed kTables[] = {
      {"keyframes", sizeof(Map::keyframes)},
      {"landmarks", sizeof(Map::landmarks)},
      {"frames and tracks before the map", sizeof(State::tracks)},
      {"job: start of a map", sizeof(MapJob::start)},
      {"job: adjustment", sizeof(MapJob::adjustment)},
      {"job: fit of the dynamics", sizeof(FitJob)},
      {"job: shape", sizeof(ShapeJob)},
      {"poses so far", sizeof(State::motion)},
      {"features of the frame", sizeof(State::features)},
      {"reference of optical flow", sizeof(State::reference)},
      {"matches of the frame and of a closure", sizeof(State::localised) + sizeof(State::closure)},
      {"working memory of detection", sizeof(State::feature_workspace)},
      {"working memory of matching", sizeof(State::localise_scratch) + sizeof(State::create_scratch)},
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

Result<Component*> Component::create(std::span<std::byte> memory, const Parameters& parameters) {
  if (auto problem = check(parameters)) {
    return *problem;
  }
  const bool aligned = reinterpret_cast<std::uintptr_t>(memory.data()) % kAlignment == 0;
  if (memory.size() < sizeof(Storage) || !aligned) {
    return Error{ErrorCode::kMemoryTooSmall,
                 "memory must hold memory_needed().total octets, aligned to 64"};
  }
  auto* storage = ::new (static_cast<void*>(memory.data())) Storage;
  storage->state.parameters = parameters;
  storage->state.camera = to_model(parameters.camera);
  storage->state.bus.memory_octets = sizeof(Storage);
  storage->state.bus.table_crc = table_crc(parameters);
  return ::new (static_cast<void*>(storage->component)) Component(&storage->state);
}

void Component::destroy(Component* component) {
  // The component's own part has nothing to give back.
  std::destroy_at(reinterpret_cast<Storage*>(component->state_));
}

void Component::set_stage_hook(StageHook hook, void* context) {
  state_->hook = hook;
  state_->hook_context = context;
}

void Component::set_mask_network(const MaskNetwork& network) {
  state_->mask_state.network = network;
}

const Counters& Component::counters() const { return state_->counters; }

std::uint32_t Component::next_step() const { return state_->next_frame; }

}  // namespace polhode
