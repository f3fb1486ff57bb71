// Events of a step: counted always, sent as packets while their kind is not too many.
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
  std::uint32_t in_window = 0;     ///< sent within the window of frames under way
  std::uint32_t suppressed = 0;    ///< since the last one that was sent
  std::array<double, 2> values{};  ///< of the last one suppressed
};

struct EventLog {
  std::array<EventCount, kEventKinds> counts{};  ///< in the order of kEvents
  std::uint32_t window_begin = 0;                ///< its first frame
  std::uint32_t sent = 0;
  std::uint32_t suppressed = 0;
  FixedVector<EventPacket, limits::kStepEvents> waiting;  ///< of this step
};

struct EventDetails {
  std::array<double, 2> values{};  ///< not finite: sent as 0
  std::string_view word = {};      ///< cut where the text is full
};

/// Something happened. Past its id's burst in a window, or with no room left in this step, it
/// is counted only.
void report(EventId id, const EventDetails& details, EventLog* log);

/// Sends what was reported in this step.
/// @param frame  a window ends with the frame bus.event_window_frames after its first one. What was
/// suppressed in it and was followed by nothing is then told by one event of that id, with the last
/// one's numbers.
void send_events(std::uint32_t frame,
                 std::int64_t timestamp_ns,
                 const BusOptions& options,
                 EventLog* log,
                 PacketStream* stream);

/// Fills `out` with the text of an event: numbers in the shortest form that reads back, whole ones
/// without a point. @return octets written; what does not fit is cut.
std::size_t event_text(const EventRow& row, const EventDetails& details, std::span<char> out);

}  // namespace polhode::bus
