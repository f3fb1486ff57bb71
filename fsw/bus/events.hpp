// Events of a step: all are counted; of each id, a burst in a window of frames is sent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/fixed_vector.hpp"
#include "bus/capacities.hpp"
#include "bus/event_table.hpp"
#include "bus/packets.hpp"
#include "bus/telemetry.hpp"

namespace polhode::bus {

struct EventCount {
  std::uint32_t occurrences = 0;
  std::uint32_t in_window = 0;     ///< sent within the current window of frames
  std::uint32_t suppressed = 0;    ///< since the last one that was sent
  std::array<double, 2> values{};  ///< of the last suppressed one
};

struct EventLog {
  std::array<EventCount, kEventKinds> counts{};  ///< in the order of kEvents
  std::uint32_t window_begin = 0;                ///< its first frame
  std::uint32_t sent = 0;
  std::uint32_t suppressed = 0;
  std::uint16_t command_sequence = 0;  ///< of the command that is being carried out; 0: none
  FixedVector<EventPacket, limits::kStepEvents> waiting;  ///< of this step
};

struct EventDetails {
  std::array<double, 2> values{};  ///< not finite: sent as 0
  std::string_view word = {};      ///< cut where the text is full
};

/// Implementation of the functions of event_reports.hpp; all other code reports events by those.
/// Past its id's burst in a window, or with no room left in this step, an event is only counted.
void log_event(EventId id, const EventDetails& details, EventLog* log);

/// Sends the events of this step.
/// @param frame  a window ends with the frame bus.event_window_frames after its first one. Events
/// still suppressed are then reported by one event of their id, with the numbers of the last one.
void send_events(std::uint32_t frame,
                 std::int64_t timestamp_ns,
                 const BusOptions& options,
                 EventLog* log,
                 PacketStream* stream);

/// Fills `out` with the text of an event, by its row's pattern: numbers with six digits, whole ones
/// in full and without a point. @return octets written; text beyond `out` is cut.
std::size_t event_text(std::string_view pattern, const EventDetails& details, std::span<char> out);

}  // namespace polhode::bus
