#include "bus/publish.hpp"

#include <algorithm>

#include "bus/bus_state.hpp"
#include "bus/counter_table.hpp"
#include "bus/narrow.hpp"
#include "bus/publish_motion.hpp"
#include "bus/report_changes.hpp"
#include "bus/shape_telemetry.hpp"
#include "shape/scale_state.hpp"
#include "shape/shape_state.hpp"

namespace polhode::bus {
namespace {

bool due(std::uint32_t frame, int every_frames) {
  return frame % static_cast<std::uint32_t>(every_frames) == 0;
}

std::uint8_t flag_if(bool up, std::uint8_t flag) { return up ? flag : std::uint8_t{0}; }

void put_counters(const Counters& counters, HousekeepingPacket* packet) {
  for (const CounterRow& row : kCounters) {
    packet->*row.published = counters.*row.counted;
  }
}

std::size_t chunks_left(const CloudRequest& cloud) {
  return chunks_of(cloud.points_T.size() - cloud.next);
}

std::array<std::uint8_t, 3> version_numbers(std::string_view version) {
  std::array<std::uint8_t, 3> numbers{};
  std::size_t part = 0;
  for (const char c : version) {
    if (c == '.') {
      ++part;
    } else if (part < numbers.size()) {
      numbers[part] = static_cast<std::uint8_t>(10 * numbers[part] + (c - '0'));
    }
  }
  return numbers;
}

void send_housekeeping(const View& view, BusState* bus) {
  namespace flag = housekeeping_layout;
  const MotionState& motion = *view.motion;
  HousekeepingPacket packet;
  packet.timestamp_ns = motion.timestamp_ns;
  packet.memory_octets = view.table.memory_octets;
  packet.frame = motion.frame;
  put_counters(*view.counters, &packet);
  packet.commands_accepted = bus->commands.accepted;
  packet.commands_rejected = bus->commands.rejected;
  packet.last_command = bus->commands.last_code;
  packet.last_rejection = static_cast<std::uint8_t>(bus->commands.last_rejection);
  packet.events_sent = bus->events.sent;
  packet.events_suppressed = bus->events.suppressed;
  packet.packets_not_sent = bus->stream.not_sent;
  packet.table_crc = view.table.crc;
  packet.table_loaded_crc = view.table.loaded_crc;
  packet.table_entries = clipped(view.table.loaded_entries);
  packet.landmarks = motion.landmarks;
  packet.keyframes = motion.keyframes;
  packet.cloud_chunks_left = clipped(chunks_left(bus->cloud));
  packet.mode = static_cast<std::uint8_t>(motion.mode);
  packet.version = version_numbers(view.version);
  packet.flags = static_cast<std::uint8_t>(
      flag_if(view.held, flag::kFlagHeld) | flag_if(view.scale->known, flag::kFlagScaleKnown) |
      flag_if(view.table.loaded, flag::kFlagTableLoaded) |
      flag_if(bus->servicer.known, flag::kFlagServicerAttitude) |
      flag_if(view.camera.found->is(Deviation::kFocal), flag::kFlagFocalLengthDoubted) |
      flag_if(view.camera.found->any(), flag::kFlagCameraContradicted));
  packet.tables_damaged = clipped_to_octet(bus->tables_damaged);
  append(packet, *view.options, &bus->stream);
}

/// A new estimate, or the last one again.
void send_shape(const View& view, BusState* bus) {
  const ShapeState& now = *view.shape;
  if (!now.shape || !(now.is_new || due(view.motion->frame, view.options->shape_every_frames))) {
    return;
  }
  ShapePacket packet = to_packet(*now.shape, view.unit);
  packet.timestamp_ns = view.motion->timestamp_ns;
  packet.frame = view.motion->frame;
  packet.frame_of_estimate = now.frame_of_estimate;
  append(packet, *view.options, &bus->stream);
}

void send_cloud_chunk(const BusOptions& options, BusState* bus) {
  CloudRequest& cloud = bus->cloud;
  const std::size_t points = std::min(kPointsPerChunk, cloud.points_T.size() - cloud.next);
  CloudPacket packet;
  packet.timestamp_ns = cloud.timestamp_ns;
  packet.points_total = static_cast<std::uint32_t>(cloud.points_T.size());
  packet.first_point = static_cast<std::uint32_t>(cloud.next);
  packet.cloud = cloud.number;
  packet.chunk = clipped(cloud.next / kPointsPerChunk);
  packet.chunks = clipped(chunks_of(cloud.points_T.size()));
  packet.points = static_cast<std::uint8_t>(points);
  if (cloud.scale_known) {
    packet.flags = cloud_layout::kFlagScaleKnown;
    packet.metres_per_mu = cloud.metres_per_mu;
  }
  for (std::size_t i = 0; i < points; ++i) {
    std::copy_n(cloud.points_T[cloud.next + i].begin(),
                3,
                packet.p_T.begin() + 3 * static_cast<std::ptrdiff_t>(i));
  }
  cloud.next += points;
  append(packet, options, &bus->stream);
}

}  // namespace

void publish(const View& view, BusState* bus) {
  const BusOptions& options = *view.options;
  const MotionState& motion = *view.motion;
  MotionPacket packet = to_packet(motion);
  append(packet, options, &bus->stream);
  if (view.has_map) {
    const bool model_due = due(motion.frame, options.model_every_frames);
    if (model_due) {
      send_model(view, bus);
    }
    send_prediction(view, model_due, bus);
    send_shape(view, bus);
  }
  if (due(motion.frame, options.housekeeping_every_frames)) {
    send_housekeeping(view, bus);
  }
  report_changes(view, bus);
  send_events(motion.frame, motion.timestamp_ns, options, &bus->events, &bus->stream);
  for (int i = 0; i < options.cloud_chunks_per_frame && chunks_left(bus->cloud) > 0; ++i) {
    send_cloud_chunk(options, bus);
  }
}

}  // namespace polhode::bus
