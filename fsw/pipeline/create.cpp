#include "pipeline/component.hpp"

#include <cstdint>
#include <memory>
#include <new>

#include "pipeline/parameter_image.hpp"
#include "pipeline/point_question.hpp"
#include "pipeline/storage.hpp"

namespace polhode {

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
          .p2 = c.p2,
          .line_time_s = 1e-9 * c.line_time_ns};
}

Result<Component*> Component::create(std::span<std::byte> memory, const Parameters& parameters) {
  if (auto problem = check(parameters)) {
    return *problem;
  }
  const bool aligned = reinterpret_cast<std::uintptr_t>(memory.data()) % alignof(Storage) == 0;
  if (memory.size() < sizeof(Storage) || !aligned) {
    return Error{ErrorCode::kMemoryTooSmall,
                 "memory must hold memory_needed().total octets, aligned to 64"};
  }
  auto* storage = ::new (static_cast<void*>(memory.data())) Storage;
  Configuration& configuration = storage->state.configuration;
  configuration.parameters = parameters;
  configuration.spare = parameters;
  configuration.camera = to_model(parameters.camera);
  configuration.memory_octets = sizeof(Storage);
  configuration.background_planned = parameters.mask.separates_background();
  configuration.table_crc = table_crc(parameters);
  return ::new (static_cast<void*>(storage->component)) Component(&storage->state);
}

void Component::destroy(Component* component) {
  // The component's own part has nothing to give back.
  std::destroy_at(reinterpret_cast<Storage*>(component->state_));
}

void Component::set_stage_hook(StageHook hook, void* context) {
  state_->timer = {.hook = hook, .context = context};
}

const Counters& Component::counters() const { return state_->counters; }

std::string_view Component::predict_point(const PointQuestion& question, PointState* answer) const {
  return polhode::predict_point(question, *state_, answer);
}

std::uint32_t Component::next_step() const { return state_->clock.next_frame; }

}  // namespace polhode
