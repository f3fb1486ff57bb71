#include "bus/events.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace polhode::bus {
namespace {

constexpr double kWholeNumbersUpTo = 9.0e15;  // just under 2^53: whole numbers below are exact
constexpr int kDigits = 6;                    // chosen for people; the packet has the exact value

/// Text that grows up to the end of its buffer.
class Line {
 public:
  explicit Line(std::span<char> out) : out_(out) {}
  void add(std::string_view text) {
    const std::size_t fits = std::min(text.size(), out_.size() - size_);
    std::copy_n(text.begin(), fits, out_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += fits;
  }
  void add(double value) {
    char text[32];
    const bool whole = value == std::floor(value) && std::abs(value) < kWholeNumbersUpTo;
    const std::to_chars_result end =
        whole ? std::to_chars(text, text + sizeof text, static_cast<std::int64_t>(value))
              : std::to_chars(text, text + sizeof text, value, std::chars_format::general, kDigits);
    add(std::string_view(text, static_cast<std::size_t>(end.ptr - text)));
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::span<char> out_;
  std::size_t size_ = 0;
};

std::size_t index_of(EventId id) {
  const auto row =
      std::find_if(kEvents.begin(), kEvents.end(), [id](const EventRow& r) { return r.id == id; });
  POLHODE_ASSERT(row != kEvents.end(), static_cast<int>(id));
  return static_cast<std::size_t>(row - kEvents.begin());
}

double finite(double value) { return std::isfinite(value) ? value : 0.0; }

/// @param command_sequence  of the command that it answers, or 0.
EventPacket packet_of(std::size_t index,
                      const EventDetails& details,
                      const EventCount& count,
                      std::uint16_t command_sequence) {
  const EventRow& row = kEvents[index];
  EventPacket packet;
  packet.value = {finite(details.values[0]), finite(details.values[1])};
  packet.occurrences = count.occurrences;
  packet.suppressed = count.suppressed;
  packet.command_sequence = command_sequence;
  packet.id = static_cast<std::uint16_t>(row.id);
  packet.severity = static_cast<std::uint8_t>(row.severity);
  packet.text_octets = static_cast<std::uint8_t>(
      event_text(row.text, {.values = packet.value, .word = details.word}, packet.text));
  return packet;
}

/// Ends a window and reports the events still suppressed.
void end_window(std::uint32_t frame, EventLog* log) {
  log->window_begin = frame;
  for (std::size_t i = 0; i < kEventKinds; ++i) {
    EventCount& count = log->counts[i];
    count.in_window = 0;
    if (count.suppressed != 0 && !log->waiting.full()) {
      (void)log->waiting.push_back(
          packet_of(i, {.values = count.values, .word = "(repeated)"}, count, 0));
      count.suppressed = 0;
      ++count.in_window;
      ++log->sent;
    }
  }
}

}  // namespace

std::size_t event_text(std::string_view pattern, const EventDetails& details, std::span<char> out) {
  Line line(out);
  std::string_view rest = pattern;
  while (!rest.empty()) {
    const std::size_t open = rest.find('{');
    line.add(rest.substr(0, open));
    if (open == std::string_view::npos) {
      break;
    }
    const std::size_t close = rest.find('}', open);
    const std::string_view key = rest.substr(open + 1, close - open - 1);
    if (key.empty()) {
      line.add(details.word);
    } else {
      line.add(details.values[key == "0" ? 0 : 1]);
    }
    rest.remove_prefix(close + 1);
  }
  return line.size();
}

void log_event(EventId id, const EventDetails& details, EventLog* log) {
  const std::size_t index = index_of(id);
  EventCount& count = log->counts[index];
  ++count.occurrences;
  if (count.in_window >= kEvents[index].burst || log->waiting.full()) {
    ++count.suppressed;
    ++log->suppressed;
    count.values = details.values;
    return;
  }
  (void)log->waiting.push_back(packet_of(index, details, count, log->command_sequence));
  ++count.in_window;
  count.suppressed = 0;
  ++log->sent;
}

void send_events(std::uint32_t frame,
                 std::int64_t timestamp_ns,
                 const BusOptions& options,
                 EventLog* log,
                 PacketStream* stream) {
  if (frame - log->window_begin >= static_cast<std::uint32_t>(options.event_window_frames)) {
    end_window(frame, log);
  }
  for (EventPacket& packet : log->waiting) {
    packet.frame = frame;
    packet.timestamp_ns = timestamp_ns;
    append(packet, options, stream);
  }
  log->waiting.clear();
}

}  // namespace polhode::bus
