#include "pipeline/telemetry.hpp"

#include <algorithm>

#include "bus/counter_table.hpp"
#include "bus/narrow.hpp"
#include "pipeline/motion_telemetry.hpp"
#include "pipeline/shape_now.hpp"
#include "pipeline/tell_events.hpp"

namespace polhode {
namespace {

bool due(std::uint32_t frame, int every_frames) {
  return frame % static_cast<std::uint32_t>(every_frames) == 0;
}

std::uint8_t flag_if(bool up, std::uint8_t flag) { return up ? flag : std::uint8_t{0}; }

void put_counters(const Counters& counters, bus::HousekeepingPacket* packet) {
  for (const bus::CounterRow& row : bus::kCounters) {
    packet->*row.published = counters.*row.counted;
  }
}

std::size_t points_per_chunk() { return std::tuple_size_v<decltype(bus::CloudPacket::p_T)> / 3; }

std::size_t chunks_left(const CloudRequest& cloud) {
  const std::size_t points = cloud.points_T.size() - cloud.next;
  return (points + points_per_chunk() - 1) / points_per_chunk();
}

/// Major, minor, patch of kVersion.
std::array<std::uint8_t, 3> version_numbers() {
  std::array<std::uint8_t, 3> numbers{};
  std::size_t part = 0;
  for (const char* c = kVersion; *c != '\0' && part < numbers.size(); ++c) {
    if (*c == '.') {
      ++part;
    } else {
      numbers[part] = static_cast<std::uint8_t>(10 * numbers[part] + (*c - '0'));
    }
  }
  return numbers;
}

void send_housekeeping(const MotionState& motion, Component::State* s) {
  namespace flag = bus::housekeeping_layout;
  const BusState& bus = s->bus;
  bus::HousekeepingPacket packet;
  packet.timestamp_ns = motion.timestamp_ns;
  packet.memory_octets = bus.memory_octets;
  packet.frame = motion.frame;
  put_counters(s->counters, &packet);
  packet.commands_accepted = bus.commands.accepted;
  packet.commands_rejected = bus.commands.rejected;
  packet.last_command = bus.commands.last_code;
  packet.last_rejection = static_cast<std::uint8_t>(bus.commands.last_rejection);
  packet.events_sent = bus.events.sent;
  packet.events_suppressed = bus.events.suppressed;
  packet.packets_not_sent = bus.stream.not_sent;
  packet.table_crc = bus.table_crc;
  packet.table_loaded_crc = bus.inactive.crc;
  packet.table_entries = bus::clipped(bus.inactive.entries);
  packet.landmarks = motion.landmarks;
  packet.keyframes = motion.keyframes;
  packet.cloud_chunks_left = bus::clipped(chunks_left(bus.cloud));
  packet.mode = static_cast<std::uint8_t>(motion.mode);
  packet.version = version_numbers();
  packet.flags = static_cast<std::uint8_t>(
      flag_if(bus.held, flag::kFlagHeld) | flag_if(s->scale.known, flag::kFlagScaleKnown) |
      flag_if(bus.inactive.begun, flag::kFlagTableLoaded) |
      flag_if(bus.servicer.known, flag::kFlagServicerAttitude));
  append(packet, s->parameters.bus, &s->bus.stream);
}

void send_cloud_chunk(Component::State* s) {
  CloudRequest& cloud = s->bus.cloud;
  const std::size_t points = std::min(points_per_chunk(), cloud.points_T.size() - cloud.next);
  bus::CloudPacket packet;
  packet.timestamp_ns = cloud.timestamp_ns;
  packet.points_total = static_cast<std::uint32_t>(cloud.points_T.size());
  packet.first_point = static_cast<std::uint32_t>(cloud.next);
  packet.cloud = cloud.number;
  packet.chunk = bus::clipped(cloud.next / points_per_chunk());
  packet.chunks =
      bus::clipped((cloud.points_T.size() + points_per_chunk() - 1) / points_per_chunk());
  packet.points = static_cast<std::uint8_t>(points);
  if (cloud.scale_known) {
    packet.flags = bus::cloud_layout::kFlagScaleKnown;
    packet.metres_per_mu = cloud.metres_per_mu;
  }
  for (std::size_t i = 0; i < points; ++i) {
    std::copy_n(cloud.points_T[cloud.next + i].begin(),
                3,
                packet.p_T.begin() + 3 * static_cast<std::ptrdiff_t>(i));
  }
  cloud.next += points;
  append(packet, s->parameters.bus, &s->bus.stream);
}

}  // namespace

void begin_telemetry(Component::State* s) {
  s->bus.stream.size = 0;
  s->output.checkpoint_asked = false;
}

void send_telemetry(FrameUse use, const MotionState& motion, Component::State* s) {
  const BusOptions& options = s->parameters.bus;
  bus::MotionPacket packet = bus::to_packet(motion);
  append(packet, options, &s->bus.stream);
  if (s->map.landmark_count > 0) {
    const bool model_due = due(motion.frame, options.model_every_frames);
    if (model_due) {
      send_model(motion, s);
    }
    send_prediction(motion, model_due, s);
    send_shape(motion, s);
  }
  if (due(motion.frame, options.housekeeping_every_frames)) {
    send_housekeeping(motion, s);
  }
  tell_events(use, motion, s);
  bus::send_events(motion.frame, motion.timestamp_ns, options, &s->bus.events, &s->bus.stream);
  for (int i = 0; i < options.cloud_chunks_per_frame && chunks_left(s->bus.cloud) > 0; ++i) {
    send_cloud_chunk(s);
  }
  s->output.packets = s->bus.stream.view();
}

}  // namespace polhode
