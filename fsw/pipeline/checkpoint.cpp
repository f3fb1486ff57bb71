#include "pipeline/checkpoint.hpp"

#include <cstring>

#include "base/assert.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

/// Everything whose size shows that a table's entry has changed.
struct Fingerprint {
  std::uint64_t version = 4;  ///< changes when the order or the meaning of the content does
  std::uint64_t keyframe = sizeof(Keyframe);
  std::uint64_t landmark = sizeof(Landmark);
  std::uint64_t pose = sizeof(PoseSample);
  std::uint64_t counters = sizeof(Counters);
  std::uint64_t remembered = 0;
  bool operator==(const Fingerprint&) const = default;
};

/// Single values of the state, in one place for both directions.
struct Remembered {
  Counters counters;
  ScaleState scale;
  std::int64_t timestamp_ns = 0;
  bool time_known = false;
  ShapeState shape;
  MapDrift drift;
  std::uint32_t target_frame = 0;
  double noise_scale = 1.0;
  LastAdjustment last_adjustment_of_all;
  bool loop_open = false;
  Eigen::Matrix3d R_IC;
  bool observer_known = false;
  RigidModel model;
  std::uint32_t poses_since_fit = 0;
  std::uint32_t poses_since_start = 0;
  std::uint32_t disagreements = 0;
  std::array<double, 4> q_CT_last{};
  std::uint32_t next_frame = 0;
  Parameters parameters;  ///< as activated by command
  BusRemembered bus;
  std::uint32_t next_keyframe_number = 0;
  std::int32_t next_landmark_number = 0;
  std::int32_t keyframe_count = 0;
  std::int32_t landmark_count = 0;
  Eigen::Vector3d centre_T;
  double radius_mu = 0.0;
};

Fingerprint fingerprint() { return {.remembered = sizeof(Remembered)}; }

/// Jobs that are out are lost with the process: what they were for is still to be done.
bool loop_open(const Component::State& s) {
  const bool out = s.job.kind == JobKind::kAdjustment && !s.job.unwanted;
  return s.growth.closed || (out && s.job.adjustment.closed);
}

ShapeState asked_again(ShapeState shape, const ShapeJob& job) {
  shape.keyframe_asked = job.kind == JobKind::kNone ? shape.keyframe_asked : 0;
  return shape;
}

Remembered remember(const Component::State& s) {
  return {.counters = s.counters,
          .scale = s.scale,
          .timestamp_ns = s.timestamp_ns,
          .time_known = s.time_known,
          .shape = asked_again(s.shape, s.shape_job),
          .drift = s.drift,
          .target_frame = s.target_frame,
          .noise_scale = s.noise_scale,
          .last_adjustment_of_all = s.last_adjustment_of_all,
          .loop_open = loop_open(s),
          .R_IC = s.motion.R_IC,
          .observer_known = s.motion.observer_known,
          .model = s.motion.model,
          .poses_since_fit = s.motion.poses_since_fit,
          .poses_since_start = s.motion.poses_since_start,
          .disagreements = s.motion.disagreements,
          .q_CT_last = s.q_CT_last,
          .next_frame = s.next_frame,
          .parameters = s.parameters,
          .bus = remember(s.bus),
          .next_keyframe_number = s.map.next_keyframe_number,
          .next_landmark_number = s.map.next_landmark_number,
          .keyframe_count = s.map.keyframe_count,
          .landmark_count = s.map.landmark_count,
          .centre_T = s.map.centre_T,
          .radius_mu = s.map.radius_mu};
}

void recall(const Remembered& r, Component::State* s) {
  s->counters = r.counters;
  s->scale = r.scale;
  s->timestamp_ns = r.timestamp_ns;
  s->time_known = r.time_known;
  s->shape = r.shape;
  s->drift = r.drift;
  s->target_frame = r.target_frame;
  s->noise_scale = r.noise_scale;
  s->last_adjustment_of_all = r.last_adjustment_of_all;
  s->growth.closed = r.loop_open;
  s->motion.R_IC = r.R_IC;
  s->motion.observer_known = r.observer_known;
  s->motion.model = r.model;
  s->motion.poses_since_fit = r.poses_since_fit;
  s->motion.poses_since_start = r.poses_since_start;
  s->motion.disagreements = r.disagreements;
  s->q_CT_last = r.q_CT_last;
  s->next_frame = r.next_frame;
  s->parameters = r.parameters;
  recall(r.bus, &s->bus);
  s->map.next_keyframe_number = r.next_keyframe_number;
  s->map.next_landmark_number = r.next_landmark_number;
  s->map.keyframe_count = r.keyframe_count;
  s->map.landmark_count = r.landmark_count;
  s->map.centre_T = r.centre_T;
  s->map.radius_mu = r.radius_mu;
}

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> out) : out_(out) {}
  /// Objects without pointers, as they lie in memory.
  template <typename T>
  void put(const T& value) {
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

bool is_whole(Reader in, const Component::State& s) {
  Fingerprint theirs;
  return in.take(&theirs) && theirs == fingerprint() && in.skip(sizeof(Remembered)) &&
         in.skip(2 * sizeof(PoseHistory)) && slots_are_whole(&in, s.map.keyframes) &&
         slots_are_whole(&in, s.map.landmarks) && in.at_end();
}

}  // namespace

std::size_t checkpoint_octets_max() {
  constexpr std::size_t kPlace = sizeof(std::uint32_t);
  return sizeof(Fingerprint) + sizeof(Remembered) + 2 * sizeof(PoseHistory) + 2 * kPlace +
         limits::kKeyframes * (kPlace + sizeof(Keyframe)) +
         limits::kLandmarks * (kPlace + sizeof(Landmark));
}

std::size_t save_checkpoint(const Component::State& state, std::span<std::uint8_t> out) {
  Writer writer(out);
  writer.put(fingerprint());
  writer.put(remember(state));
  writer.put(state.motion.recent);
  writer.put(state.motion.past);
  put_used(state.map.keyframes, &writer);
  put_used(state.map.landmarks, &writer);
  return writer.used();
}

bool restore_checkpoint(std::span<const std::uint8_t> octets, Component::State* state) {
  Reader reader(octets);
  if (!is_whole(reader, *state)) {
    return false;
  }
  Remembered remembered;
  const bool taken = reader.skip(sizeof(Fingerprint)) && reader.take(&remembered) &&
                     reader.take(&state->motion.recent) && reader.take(&state->motion.past);
  POLHODE_ASSERT(taken, octets.size());
  clear(&state->map);
  take_used(&reader, &state->map.keyframes);
  take_used(&reader, &state->map.landmarks);
  recall(remembered, state);
  state->mode = state->map.keyframe_count > 0 ? Mode::kLost : Mode::kIdle;
  state->reference.valid = false;
  return true;
}

}  // namespace polhode
