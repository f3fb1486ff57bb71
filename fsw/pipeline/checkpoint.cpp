#include "pipeline/checkpoint.hpp"

#include <cstring>
#include <type_traits>

#include "base/assert.hpp"
#include "base/validity.hpp"
#include "pipeline/soundness.hpp"
#include "pipeline/storage.hpp"

namespace polhode {
namespace {

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> out) : out_(out) {}
  /// Objects without pointers, as they lie in memory.
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_destructible_v<T> && !std::is_pointer_v<T>);
    POLHODE_ASSERT(used_ + sizeof(T) <= out_.size(), used_);
    std::memcpy(out_.data() + used_, static_cast<const void*>(&value), sizeof(T));
    used_ += sizeof(T);
  }
  [[nodiscard]] std::size_t used() const { return used_; }

 private:
  std::span<std::uint8_t> out_;
  std::size_t used_ = 0;
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> octets) : octets_(octets) {}
  template <typename T>
  [[nodiscard]] bool take(T* value) {
    if (octets_.size() < sizeof(T)) {
      return false;
    }
    std::memcpy(static_cast<void*>(value), octets_.data(), sizeof(T));
    octets_ = octets_.subspan(sizeof(T));
    return true;
  }
  [[nodiscard]] bool skip(std::size_t octets) {
    const bool there = octets <= octets_.size();
    octets_ = there ? octets_.subspan(octets) : octets_;
    return there;
  }
  [[nodiscard]] bool at_end() const { return octets_.empty(); }

 private:
  std::span<const std::uint8_t> octets_;
};

/// The used slots of a table, each with its place.
template <typename Table>
void put_used(const Table& table, Writer* out) {
  std::uint32_t count = 0;
  for (const auto& slot : table) {
    count += slot.used ? 1 : 0;
  }
  out->put(count);
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    if (table[i].used) {
      out->put(i);
      out->put(table[i]);
    }
  }
}

template <typename Table>
bool slots_are_whole(Reader* in, const Table& table) {
  std::uint32_t count = 0;
  if (!in->take(&count) || count > table.size()) {
    return false;
  }
  for (std::uint32_t n = 0; n < count; ++n) {
    std::uint32_t place = 0;
    if (!in->take(&place) || place >= table.size() || !in->skip(sizeof(table[0]))) {
      return false;
    }
  }
  return true;
}

/// After slots_are_whole().
template <typename Table>
void take_used(Reader* in, Table* table) {
  std::uint32_t count = 0;
  const bool counted = in->take(&count);
  POLHODE_ASSERT(counted, count);
  for (std::uint32_t n = 0; n < count; ++n) {
    std::uint32_t place = 0;
    const bool taken = in->take(&place) && in->take(&(*table)[place]);
    POLHODE_ASSERT(taken, place);
  }
}

/// State that survives a restart, room by room: the one list for both directions. Tables with
/// unused slots follow after it. All members of a room are bound here, so that a new member does
/// not compile until it is decided whether it survives.
/// @param visit  called with each value.
template <typename Visitor, typename State>
void visit_persistent(Visitor&& visit, State& s) {
  const auto all = [&](auto&... values) { (visit(values), ...); };
  // clang-format off
  auto& [configuration, counters, mode, clock, to_shed, picture, features, initialisation, mapping,
         motion, shape, scale, camera, jobs, bus, answer, timer] = s;
  auto& [map, drift, target_frame, reference, pyramid, localised, has_pose, teaches, doubted,
         before, growth, last_adjustment, moved_rad, map_counts, scratch] = mapping;
  auto& [stream, events, commands, commands_done, cloud, servicer, predictions, reported,
         bus_scale, q_CT_last, tables_damaged] = bus;
  // clang-format on
  auto& [event_counts, window_begin, sent, suppressed, command_sequence, waiting] = events;
  all(configuration.parameters, configuration.table_crc);  // as activated by command
  all(counters, map_counts, jobs.counts);  // a checkpoint may be written within a step
  all(mode.held, clock.next_frame, clock.timestamp_ns, clock.time_known);
  all(drift, target_frame, map.next_keyframe_number, map.next_landmark_number);
  all(map.keyframe_count, map.landmark_count, map.centre_T, map.radius_mu);
  all(motion, shape, scale, camera, features.resting, last_adjustment);
  all(stream.sequence, stream.not_sent, event_counts, window_begin, sent, suppressed);
  all(commands, commands_done, cloud.number, servicer, reported, bus_scale, q_CT_last);
}

/// Jobs that are out are lost with the process. Loop closure and shape are then requested again.
struct WorkLost {
  bool loop_open = false;
  bool shape_asked = false;
};

WorkLost work_lost(const JobQueue& jobs, const GrowthWaiting& growth) {
  const bool adjusts = is_out_with<AdjustmentJob>(jobs.map) && !jobs.map.unwanted;
  return {.loop_open = growth.closed || (adjusts && jobs.adjustment.closed),
          .shape_asked = is_out_with<ShapeJob>(jobs.shape)};
}

/// Sizes of all values and entries, to detect a changed layout.
struct Fingerprint {
  std::uint64_t version = 9;  ///< changes when the order or the meaning of the content does
  std::uint64_t keyframe = sizeof(Keyframe);
  std::uint64_t landmark = sizeof(Landmark);
  std::uint64_t values = 0;  ///< octets of all values together
  std::uint64_t mixed = 0;   ///< their sizes in order
  bool operator==(const Fingerprint&) const = default;
};

Fingerprint fingerprint(const Component::State& s) {
  constexpr std::uint64_t kPrime = 1099511628211U;  // FNV-1a's, 64 bits
  Fingerprint sizes;
  visit_persistent(
      [&](const auto& value) {
        sizes.values += sizeof(value);
        sizes.mixed = (sizes.mixed ^ sizeof(value)) * kPrime;
      },
      s);
  return sizes;
}

bool is_whole(Reader in, const Component::State& s) {
  Fingerprint theirs;
  const Fingerprint ours = fingerprint(s);
  return in.take(&theirs) && theirs == ours && in.skip(ours.values + sizeof(WorkLost)) &&
         slots_are_whole(&in, s.mapping.map.keyframes) &&
         slots_are_whole(&in, s.mapping.map.landmarks) && in.at_end();
}

/// As Component::create() had left it, with the caller's hooks.
void begin_anew(const Parameters& parameters, Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  const StageTimer timer = s->timer;
  const OwnStructure* const own = s->picture.own;
  auto* memory = reinterpret_cast<std::byte*>(s);  // the state lies first in its storage
  Component::destroy(component);
  const Result<Component*> made = Component::create({memory, sizeof(Storage)}, parameters);
  POLHODE_ASSERT(made.ok(), 0.0);
  made.value()->set_stage_hook(timer.hook, timer.context);
  s->picture.own = own;
}

/// @return whether the values are such as a component leaves.
bool take_values(Reader reader, Component::State* s) {
  bool taken = reader.skip(sizeof(Fingerprint));
  clear(&s->mapping.map);
  visit_persistent([&](auto& value) { taken = taken && reader.take(&value); }, *s);
  WorkLost lost;
  taken = taken && reader.take(&lost);
  POLHODE_ASSERT(taken, s->mapping.map.keyframe_count);
  take_used(&reader, &s->mapping.map.keyframes);
  take_used(&reader, &s->mapping.map.landmarks);
  if (!validity::is_bool(lost.loop_open) || !validity::is_bool(lost.shape_asked) || !is_valid(*s)) {
    return false;
  }
  s->mapping.growth.closed = lost.loop_open;
  s->camera.waits = false;  // the prepared test is lost; the next has twice the keyframes
  if (lost.shape_asked) {
    ask_shape_again(&s->shape);
  }
  return true;
}

}  // namespace

std::size_t checkpoint_octets_max() {
  constexpr std::size_t kPlace = sizeof(std::uint32_t);
  // The structs of visit_persistent(), and room for its single numbers and short arrays.
  constexpr std::size_t kValuesMax =
      sizeof(Parameters) + sizeof(Counters) + sizeof(MapDrift) + sizeof(MotionEstimate) +
      sizeof(ShapeState) + sizeof(ScaleState) + sizeof(CameraState) + sizeof(RestingPlaces) +
      sizeof(bus::EventLog::counts) + sizeof(CommandCounts) + sizeof(bus::CommandsDone) +
      sizeof(ServicerAttitude) + sizeof(Reported) + 1024;
  return sizeof(Fingerprint) + kValuesMax + sizeof(WorkLost) + 2 * kPlace +
         limits::kKeyframes * (kPlace + sizeof(Keyframe)) +
         limits::kLandmarks * (kPlace + sizeof(Landmark));
}

bool may_be_saved(const Component& component) {
  return is_valid(*ComponentAccess::state(component));
}

std::size_t save_checkpoint(const Component& component, std::span<std::uint8_t> out) {
  const Component::State& s = *ComponentAccess::state(component);
  Writer writer(out);
  writer.put(fingerprint(s));
  visit_persistent([&](const auto& value) { writer.put(value); }, s);
  writer.put(work_lost(s.jobs, s.mapping.growth));
  put_used(s.mapping.map.keyframes, &writer);
  put_used(s.mapping.map.landmarks, &writer);
  return writer.used();
}

bool restore_checkpoint(std::span<const std::uint8_t> octets, Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  const Reader reader(octets);
  if (!is_whole(reader, *s)) {
    return false;
  }
  const Parameters configured = s->configuration.parameters;
  if (!take_values(reader, s)) {
    begin_anew(configured, component);
    return false;
  }
  s->bus.reported.started = false;  // the component reports its start again
  drop_reference(&s->mapping);
  const bool has_map = s->mapping.map.keyframe_count > 0;
  change_mode(has_map ? ModeEvent::kWarmStartWithMap : ModeEvent::kWarmStartWithoutMap, &s->mode);
  return true;
}

}  // namespace polhode
