#include "app/platform_telemetry.hpp"

#include "app/live_report.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "app/machine.hpp"
#include "bus/event_table.hpp"
#include "bus/packet_layout.hpp"
#include "bus/telemetry.hpp"

namespace polhode::platform {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

bus::PlatformPacket packet_of(const LiveCounts& counts,
                              const CameraCounters& camera,
                              const Transports& transports) {
  const SendCounts sent = transports.counts();
  return {.frames_dropped = camera.frames_missing + frames_passed_over(camera, counts),
          .camera_errors = camera.frames_damaged + camera.stream_errors + camera.disconnects,
          .camera_reopened = camera.opened > 0 ? camera.opened - 1 : 0,
          .deadline_misses = static_cast<std::uint32_t>(counts.deadline.missed()),
          .jobs_late = counts.frames_dropped_for_job,
          .last_step_us = static_cast<std::uint32_t>(counts.last_step_us),
          .longest_step_us = static_cast<std::uint32_t>(counts.deadline.worst_us()),
          .packets_sent = static_cast<std::uint32_t>(sent.sent),
          .packets_dropped = static_cast<std::uint32_t>(sent.dropped),
          .commands_received = transports.commands().guard().counts().received,
          .commands_dropped = transports.commands().dropped()};
}

bus::CommandLinkPacket packet_of(const CommandPorts& ports) {
  namespace layout = bus::command_link_layout;
  const CommandGuard& guard = ports.guard();
  const CommandCounts& counts = guard.counts();
  const int flags = (guard.has_key() ? layout::kFlagKey : 0) |
                    (ports.open_to_all() ? layout::kFlagUnauthenticated : 0) |
                    (counts.numbers_not_kept > 0 ? layout::kFlagNumberNotKept : 0);
  return {.highest_number = guard.highest(),
          .received = counts.received,
          .passed = counts.passed,
          .refused_sender = counts.refused_sender,
          .refused_form = counts.refused_form,
          .refused_mac = counts.refused_mac,
          .refused_number = counts.refused_number,
          .dropped = ports.dropped(),
          .numbers_not_kept = counts.numbers_not_kept,
          .ports = static_cast<std::uint8_t>(ports.size()),
          .flags = static_cast<std::uint8_t>(flags)};
}

static_assert(bus::command_link_layout::kPacketOctets <=
                      bus::platform_event_layout::kPacketOctets &&
                  bus::platform_layout::kPacketOctets <= bus::platform_event_layout::kPacketOctets,
              "all are encoded in one place");

constexpr std::uint16_t kDiskRefused = 1;  // platform_event's id

std::uint8_t flags_of(const PlatformFacts& facts) {
  namespace layout = bus::platform_layout;
  return static_cast<std::uint8_t>((facts.watchdog ? layout::kFlagWatchdog : 0) |
                                   (facts.locked_memory ? layout::kFlagLockedMemory : 0) |
                                   (facts.real_time ? layout::kFlagRealTime : 0));
}

}  // namespace

PlatformTelemetry::PlatformTelemetry(const BusOptions& options, const PlatformFacts& facts)
    : options_(options), facts_(facts), statm_(::open("/proc/self/statm", O_RDONLY | O_CLOEXEC)) {}

PlatformTelemetry::~PlatformTelemetry() {
  if (statm_ >= 0) {
    ::close(statm_);
  }
}

/// The second number of statm, in pages; 0 where the kernel does not give it.
std::uint64_t PlatformTelemetry::resident_octets() const {
  std::array<char, 128> text{};
  if (statm_ < 0 || ::pread(statm_, text.data(), text.size() - 1, 0) <= 0) {
    return 0;
  }
  char* after_total = nullptr;
  (void)std::strtoull(text.data(), &after_total, 10);
  return std::strtoull(after_total, nullptr, 10) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void PlatformTelemetry::passed(const LiveCounts& counts,
                               const LiveCamera& camera,
                               Transports& transports,
                               std::int64_t now_ns,
                               std::int64_t frame_ns) {
  if (now_ns < due_ns_) {
    return;
  }
  begun_ns_ = due_ns_ == 0 ? now_ns : begun_ns_;
  due_ns_ = now_ns + kSecond_ns;
  bus::PlatformPacket packet = packet_of(counts, camera.counters(), transports);
  packet.timestamp_ns = frame_ns;
  packet.resident_octets = resident_octets();
  packet.resident_peak_octets = static_cast<std::uint64_t>(machine_use().peak_resident_bytes);
  packet.uptime_s = static_cast<std::uint32_t>((now_ns - begun_ns_) / kSecond_ns);
  packet.restarts = facts_.restarts;
  packet.flags = flags_of(facts_);
  send(bus::PlatformPacket::layout(), &packet, sequence_, frame_ns, transports);
  if (transports.commands().size() > 0) {
    bus::CommandLinkPacket link = packet_of(transports.commands());
    link.timestamp_ns = frame_ns;
    send(bus::CommandLinkPacket::layout(), &link, sequence_, frame_ns, transports);
  }
  ++sequence_;
}

void PlatformTelemetry::disk_refused(const WriteFailures& failures,
                                     Transports& transports,
                                     std::int64_t frame_ns) {
  bus::PlatformEventPacket event{.timestamp_ns = frame_ns,
                                 .value = {static_cast<double>(failures.packets),
                                           static_cast<double>(failures.checkpoints),
                                           static_cast<double>(failures.records),
                                           static_cast<double>(failures.streamed)},
                                 .id = kDiskRefused,
                                 .severity = static_cast<std::uint8_t>(bus::Severity::kError)};
  const int bytes = std::snprintf(
      event.text.data(),
      event.text.size(),
      "disk: not written: packets of %.0f steps, %.0f checkpoints, %.0f records, %.0f packets of "
      "files",
      event.value[0],
      event.value[1],
      event.value[2],
      event.value[3]);
  event.text_octets =
      static_cast<std::uint8_t>(std::clamp(bytes, 0, static_cast<int>(event.text.size()) - 1));
  send(bus::PlatformEventPacket::layout(), &event, events_, frame_ns, transports);
  events_ = bus::next_sequence(events_);
}

void PlatformTelemetry::send(const bus::Layout& layout,
                             void* packet,
                             std::uint16_t sequence,
                             std::int64_t frame_ns,
                             Transports& transports) {
  const std::size_t bytes = bus::encode(
      layout,
      packet,
      {.apid_first = options_.apid_first, .sequence = sequence, .timestamp_ns = frame_ns},
      bytes_);
  transports.send(std::span(bytes_).first(bytes));
}

}  // namespace polhode::platform
